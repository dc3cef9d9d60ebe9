#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "compare/report/input_files.h"
#include "compare/request/truth_request.h"
#include "compare/truth/estimator_choice.h"
#include "phase/stack/stack.h"
#include "volume/result/run_result.h"

namespace lamella {

/// The beginning of every JSON answer: format, command, stack (if there is one), seed, threads,
/// isa. An answer in memory names files from the working directory.
[[nodiscard]] nlohmann::ordered_json json_header(const std::string& command, std::uint64_t seed,
                                                 Isa isa);
[[nodiscard]] nlohmann::ordered_json json_header(const std::string& command,
                                                 const TruthRequest& request);

/// Adds "files", which the run read beside its stack file; nothing where there are none.
void add_files(nlohmann::ordered_json& answer, const InputFiles& inputs);

/// The answer with its files named for a place in `folder`, where they were named for one in
/// `from`; empty: the working directory.
[[nodiscard]] nlohmann::ordered_json named_for(nlohmann::ordered_json answer,
                                               const std::filesystem::path& folder,
                                               const std::filesystem::path& from = {});

/// The resolved stack, every default filled in; infinity is the string "inf".
[[nodiscard]] nlohmann::ordered_json to_json(const Stack& stack);

/// A number as JSON has it: infinity and nan as strings.
[[nodiscard]] nlohmann::ordered_json json_number(double value);

/// A value of a parameter: a number, a list or a string.
[[nodiscard]] nlohmann::ordered_json to_json(const ParameterValue& value);

/// Per channel, the values and the standard errors of estimates.
[[nodiscard]] nlohmann::ordered_json values_of(const std::array<Estimate, 3>& e, int channels);
[[nodiscard]] nlohmann::ordered_json errors_of(const std::array<Estimate, 3>& e, int channels);

/// The estimator that was used, the one that was asked for, and why: "estimator",
/// "estimator_asked", "estimator_reason", and the solver's "tolerance".
void add_choice(nlohmann::ordered_json& answer, const EstimatorChoice& choice,
                const TruthRequest& request);

/// One incident direction of `simulate`.
[[nodiscard]] nlohmann::ordered_json to_json(const RunResult& run);

/// Writes the answer to a file, its files named for that place, or to stdout if that is "-";
/// nothing if the path is empty.
void write_json(const nlohmann::ordered_json& answer, const std::string& path);

}  // namespace lamella
