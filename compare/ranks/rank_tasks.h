#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "compare/ranks/ranks.h"
#include "compare/request/interrupt.h"

namespace lamella {

/// Does one task and returns what was found as bytes.
using RankTask = std::function<std::string(std::uint64_t task)>;

/// On rank 0: hands out tasks to whichever rank is free, itself among them, in the order of the
/// list, until all are done or `stop` is set. `keep` is told of each task that is done, on this
/// rank, one at a time, as soon as it is known. Returns the tasks that were done. Throws what
/// `find` and `keep` throw.
[[nodiscard]] std::set<std::uint64_t> serve_tasks(
    Ranks& ranks, const std::vector<std::uint64_t>& tasks, const RankTask& find,
    const std::function<void(std::uint64_t task, const std::string& found)>& keep,
    const StopFlag* stop);

/// On the other ranks: does what rank 0 hands out, until there is no more.
void work_on_tasks(Ranks& ranks, const RankTask& find, const StopFlag* stop);

}  // namespace lamella
