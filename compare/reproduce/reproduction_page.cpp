#include "compare/reproduce/reproduction_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kStyle =
    "body{font:15px/1.45 system-ui,sans-serif;margin:2em auto;max-width:1100px;padding:0 "
    "1em;color:#222}"
    "h2{border-top:1px solid #ccc;padding-top:1em;margin-top:2em}"
    "table{border-collapse:collapse;font-size:13px}td,th{padding:2px "
    "8px;text-align:right;border-bottom:1px solid #eee}"
    "td.text,th.text{text-align:left}img{max-width:100%;margin:6px 0}"
    ".agrees,.differs{white-space:nowrap}.agrees{color:#00663d}.differs{color:#a33a00}details{"
    "margin:.6em 0}"
    "@media(prefers-color-scheme:dark){body{background:#16181c;color:#ddd}td,th{border-color:#333}"
    ".agrees{color:#5fd3a0}.differs{color:#ff9d66}}";

std::string for_html(const std::string& text) {
  std::string out;
  for (const char c : text) switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  return out;
}

// A value of a row as people read it.
std::string cell_text(const Json& value) {
  if (value.is_string()) return for_html(value.get<std::string>());
  if (value.is_number_float()) return fmt::format("{:.5g}", value.get<double>());
  return for_html(value.is_null() ? "" : value.dump());
}

// The rows with the keys of the first as columns; rows with other keys begin a table of their own.
std::string tables_of(const Json& rows) {
  std::string out, columns;
  for (const Json& row : rows) {
    std::string keys;
    for (const auto& [key, value] : row.items()) keys += "<th>" + for_html(key) + "</th>";
    if (keys != columns) {
      out += (columns.empty() ? "" : "</table>\n") + ("<table><tr>" + keys + "</tr>\n");
      columns = keys;
    }
    out += "<tr>";
    for (const auto& [key, value] : row.items())
      out += fmt::format("<td{}>{}</td>", value.is_string() ? " class=\"text\"" : "",
                         cell_text(value));
    out += "</tr>\n";
  }
  return out + (columns.empty() ? "" : "</table>\n");
}

// "5 of 6 agree"
std::string tally_of(const Json& findings) {
  int agree = 0;
  for (const Json& f : findings) agree += f["agrees"].get<bool>();
  if (findings.empty()) return "";
  return fmt::format("<span class=\"{}\">{} of {} agree</span>",
                     agree == static_cast<int>(findings.size()) ? "agrees" : "differs", agree,
                     findings.size());
}

std::string contents_of(const Json& figures) {
  std::string out =
      "<table><tr><th class=\"text\">figure</th><th "
      "class=\"text\">what</th><th>findings</th></tr>\n";
  for (const Json& f : figures)
    out += fmt::format(
        "<tr><td class=\"text\"><a href=\"#{0}\">{0}</a></td><td class=\"text\">{1}</td><td>{2}"
        "</td></tr>\n",
        for_html(f["name"].get<std::string>()), for_html(f["doc"].get<std::string>()),
        f.contains("left_out") ? "left out" : tally_of(f["findings"]));
  return out + "</table>\n";
}

// How many findings of each paper agree, in the order of the list.
std::string totals_of(const Json& figures) {
  std::vector<std::pair<std::string, Json>> papers;
  Json all = Json::array();
  for (const Json& f : figures) {
    if (f.contains("left_out")) continue;
    // "Lucas et al. 2023, Micrograin BSDF, figure 4"
    const std::string source = f["source"].get<std::string>();
    const std::string paper =
        source.substr(0, std::min(source.find(", figure"), source.find(", table")));
    if (papers.empty() || papers.back().first != paper) papers.emplace_back(paper, Json::array());
    for (const Json& finding : f["findings"]) {
      papers.back().second.push_back(finding);
      all.push_back(finding);
    }
  }
  std::string out = "<ul>\n";
  for (const auto& [paper, findings] : papers)
    if (!findings.empty())
      out += fmt::format("<li>{}: {}</li>\n", for_html(paper), tally_of(findings));
  return out + (all.empty() ? "</ul>\n" : fmt::format("<li>all: {}</li></ul>\n", tally_of(all)));
}

std::string figure_of(const Json& f) {
  const std::string name = for_html(f["name"].get<std::string>());
  std::string out =
      fmt::format("<h2 id=\"{0}\">{0}</h2>\n<p>{1}<br><em>{2}</em></p>\n", name,
                  for_html(f["doc"].get<std::string>()), for_html(f["source"].get<std::string>()));
  if (f.contains("left_out"))
    return out + "<p>Left out: " + for_html(f["left_out"].get<std::string>()) + "</p>\n";
  if (!f["findings"].empty()) {
    out +=
        "<table><tr><th class=\"text\">the paper</th><th class=\"text\">here</th><th></th></tr>\n";
    for (const Json& finding : f["findings"]) {
      const bool agrees = finding["agrees"].get<bool>();
      out += fmt::format(
          "<tr><td class=\"text\">{}</td><td class=\"text\">{}</td><td class=\"{}\">{}</td></tr>\n",
          for_html(finding["paper"].get<std::string>()),
          for_html(finding["here"].get<std::string>()), agrees ? "agrees" : "differs",
          agrees ? "agrees" : "does not agree");
    }
    out += "</table>\n";
  }
  for (const Json& picture : f["pictures"]) {
    const std::string path = for_html(picture.get<std::string>());
    if (path.ends_with(".pdf"))
      out += fmt::format("<p><a href=\"{0}/{1}\">{1}</a></p>\n", name, path);
    else
      out += fmt::format("<img src=\"{0}/{1}\" alt=\"{1}\" loading=\"lazy\">\n", name, path);
  }
  return out + fmt::format("<details><summary>{} rows, {:.1f} s</summary>\n{}</details>\n",
                           f["rows"].size(), f["seconds"].get<double>(), tables_of(f["rows"]));
}

}  // namespace

std::string reproduction_page(const Json& answer) {
  std::string out = fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n<meta name=\"viewport\" "
      "content=\"width=device-width,initial-scale=1\">\n<title>The papers, checked</title>\n"
      "<style>{}</style></head><body>\n<h1>The papers, checked</h1>\n<p>Published figures, made "
      "again by Lamella {} with <code>lamella reproduce --all --quality {}</code>, seed {}. "
      "\u201cAgrees\u201d is computed from the numbers beside it.</p>\n",
      kStyle, for_html(answer["version"].get<std::string>()),
      for_html(answer["quality"].get<std::string>()), answer["seed"].dump());
  out += totals_of(answer["reproductions"]) + contents_of(answer["reproductions"]);
  for (const Json& figure : answer["reproductions"]) out += figure_of(figure);
  return out + "</body></html>\n";
}

}  // namespace lamella
