#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace lamella {

/// One page with every figure of an answer of `lamella reproduce --all`: a table of contents, and
/// per figure its source, findings, pictures and rows. Pictures are named as the answer has them,
/// below the folder of their figure, so the page stands beside those folders. Needs no network and
/// no script. Equal answers give equal bytes.
[[nodiscard]] std::string reproduction_page(const nlohmann::ordered_json& answer);

}  // namespace lamella
