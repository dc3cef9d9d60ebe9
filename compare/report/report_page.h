#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace lamella {

/// One self-contained HTML page: the template that was built from compare/report with the numbers
/// in it. `answer`: the JSON of a command, word for word, which decides what the page shows;
/// `details`: the further data of its plots (an object or null). Equal input gives equal bytes.
[[nodiscard]] std::string report_page(const std::string& title,
                                      const nlohmann::ordered_json& answer,
                                      const nlohmann::ordered_json& details);

/// report_page to a file. Throws OutputError.
void write_report_page(const std::filesystem::path& path, const std::string& title,
                       const nlohmann::ordered_json& answer, const nlohmann::ordered_json& details);

}  // namespace lamella
