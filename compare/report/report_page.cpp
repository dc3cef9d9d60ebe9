#include "compare/report/report_page.h"

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string_view>

#include "compare/files/output_folder.h"
#include "compare/report/json_report.h"
#include "compare/report/page_template.h"

namespace lamella {
namespace {

// Inside a script element only "<" can end it; inside JSON it stands in strings alone.
std::string for_script(const nlohmann::ordered_json& value) {
  std::string text;
  for (const char c : value.dump()) {
    if (c == '<')
      text += "\\u003c";
    else
      text += c;
  }
  return text;
}

std::string for_html(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '<')
      out += "&lt;";
    else if (c == '&')
      out += "&amp;";
    else
      out += c;
  }
  return out;
}

}  // namespace

std::string report_page(const std::string& title, const nlohmann::ordered_json& answer,
                        const nlohmann::ordered_json& details) {
  const std::pair<std::string_view, std::string> places[] = {
      {"{{TITLE}}", for_html(title)},
      {"{{ANSWER}}", for_script(answer)},
      {"{{DETAILS}}", for_script(details)},
  };
  std::string_view rest = page_template();
  std::string page;
  for (const auto& [mark, text] : places) {
    const std::size_t at = rest.find(mark);
    if (at == std::string_view::npos)
      throw std::logic_error("the page's template has no " + std::string(mark));
    page += rest.substr(0, at);
    page += text;
    rest.remove_prefix(at + mark.size());
  }
  page += rest;
  return page;
}

void write_report_page(const std::filesystem::path& path, const std::string& title,
                       const nlohmann::ordered_json& answer,
                       const nlohmann::ordered_json& details) {
  write_file(path, report_page(title, named_for(answer, path.parent_path()), details));
}

}  // namespace lamella
