#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "compare/command_line/command_words.h"

namespace lamella {
namespace {

// Text as roff takes it: backslashes and hyphens escaped, no line that begins with a control
// character.
std::string roff(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else if ((c == '.' || c == '\'') && (out.empty() || out.back() == '\n'))
      out += std::string("\\&") + c;
    else
      out += c;
  }
  return out;
}

std::string option_entry(const CLI::Option& option) {
  std::string names;
  for (const std::string& name : option.get_snames()) names += (names.empty() ? "-" : ", -") + name;
  for (const std::string& name : option.get_lnames())
    names += (names.empty() ? "--" : ", --") + name;
  if (names.empty()) names = option.get_name();
  std::string entry = ".TP\n\\fB" + roff(names) + "\\fR";
  if (option.get_positional() == false && option.get_items_expected_max() > 0 &&
      !option.get_type_name().empty())
    entry += " \\fI" + roff(option.get_type_name()) + "\\fR";
  return entry + "\n" + roff(option.get_description()) + "\n";
}

}  // namespace

std::string man_page(const CLI::App& app) {
  std::string text = fmt::format(
      ".TH LAMELLA 1 \"\" \"lamella {0}\" \"User Commands\"\n.SH NAME\nlamella \\- ground truth "
      "for "
      "models of layered surfaces\n.SH SYNOPSIS\n.B lamella\n\\fICOMMAND\\fR [\\fIOPTION\\fR...]\n"
      ".SH DESCRIPTION\n{1}\n",
      LAMELLA_VERSION, roff(app.get_description()));
  text += ".SH OPTIONS\n";
  for (const CLI::Option* option : app.get_options()) text += option_entry(*option);
  text += ".SH COMMANDS\n";
  for (const CLI::App* command : app.get_subcommands({})) {
    text += fmt::format(".SS lamella {}\n{}.\n", roff(command->get_name()),
                        roff(command->get_description()));
    for (const CLI::Option* option : command->get_options())
      if (option->get_name() != "--help" &&
          option->get_lnames() != std::vector<std::string>{"help"})
        text += option_entry(*option);
    std::string footer = command->get_footer();
    if (footer.starts_with("Example: "))
      text += ".PP\nExample:\n.PP\n.nf\n.RS\n" + roff(footer.substr(9)) + "\n.RE\n.fi\n";
  }
  text +=
      ".SH EXIT STATUS\n.TP\n0\nDone and passed.\n.TP\n1\nA furnace failed, a model is farther off "
      "than \\-\\-max\\-error, or a rerun differs.\n.TP\n2\nWrong usage or bad input.\n.TP\n3\n"
      "Numbers that are not finite.\n";
  return text;
}

}  // namespace lamella
