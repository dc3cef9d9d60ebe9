#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "compare/request/run_keeper.h"
#include "compare/shards/part_file.h"

namespace lamella {

/// Gives a run the pieces that its parts found, so that nothing is left to find. Throws UsageError
/// where a piece is missing, twice there or damaged.
class MergedKeeper : public RunKeeper {
 public:
  /// The parts must outlive it.
  explicit MergedKeeper(std::vector<const Pieces*> parts) : parts_(std::move(parts)) {}
  explicit MergedKeeper(const std::vector<std::unique_ptr<PartFile>>& parts) {
    for (const auto& part : parts) parts_.push_back(part.get());
  }

  [[nodiscard]] Found begin(Simulation& simulation) override;
  void checkpoint(const Simulation&, double, bool) override {}
  void end(const Simulation&, double) override {}
  [[nodiscard]] std::optional<std::string> piece(const Make& make) override;

 private:
  std::vector<const Pieces*> parts_{};
  std::uint64_t next_ = 0;
};

/// Holds the parts of one run against each other: the same format, program version, command and
/// settings, every part once, none of them a checkpoint. Throws UsageError, which names the file.
void check_parts(const std::vector<std::unique_ptr<PartFile>>& parts);

/// In words, in which setting a run differs from another: "its seed is 2 instead of 1".
[[nodiscard]] std::string difference_of_settings(const nlohmann::ordered_json& there,
                                                 const nlohmann::ordered_json& asked);

}  // namespace lamella
