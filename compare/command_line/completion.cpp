#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "analytic/model/model.h"
#include "compare/command/command.h"
#include "compare/command_line/command_words.h"
#include "compare/request/split_text.h"
#include "phase/stack/builtin_stacks.h"

namespace lamella {
namespace {

// What may follow an option or stand as an argument.
struct Values {
  std::vector<std::string> words;  // in full
  bool files = false, folders = false;
  [[nodiscard]] bool empty() const { return words.empty() && !files && !folders; }
};

// From the name of an option's type: "a|b" are words, STACK a built-in stack or a file, ...
Values values_of(const std::string& type, const std::string& name) {
  Values values;
  if (type.find('|') != std::string::npos) {
    for (const std::string& word : split_text(type, '|')) {
      if (word.starts_with("FILE"))
        values.files = true;
      else
        values.words.push_back(word);
    }
  } else if (name == "STACK" || name == "TARGET") {
    for (const BuiltinStack& stack : builtin_stacks()) values.words.push_back(stack.name);
    values.files = true;
  } else if (name == "MODEL" || type.starts_with("NAME[")) {
    for (const ModelInfo& info : models()) values.words.push_back(info.name);
  } else if (type.starts_with("FILE")) {
    values.files = true;
  } else if (type == "FOLDER" || type == "PATH") {
    values.folders = true;
  }
  return values;
}

struct Word {
  std::vector<std::string> spellings;  // "-o", "--output"; empty: an argument
  std::string doc;
  bool takes_value = false, repeatable = false;
  Values values;
};

std::vector<Word> words_of(const CLI::App& command) {
  std::vector<Word> words;
  for (const CLI::Option* option : command.get_options()) {
    Word word;
    for (const std::string& name : option->get_snames()) word.spellings.push_back("-" + name);
    for (const std::string& name : option->get_lnames()) word.spellings.push_back("--" + name);
    word.doc = option->get_description();
    word.takes_value = option->get_items_expected_max() > 0;
    word.repeatable = option->get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll;
    word.values = values_of(option->get_type_name(), option->get_name());
    if (option->get_name() == "NAME") word.values.words = listed_names(command.get_name());
    words.push_back(std::move(word));
  }
  return words;
}

std::string joined(const std::vector<std::string>& words, const char* between) {
  return fmt::format("{}", fmt::join(words, between));
}

std::string bash_values(const Values& values) {
  std::string code;
  if (!values.words.empty())
    code += fmt::format("COMPREPLY+=($(compgen -W '{}' -- \"$cur\")); ", joined(values.words, " "));
  if (values.files) code += "compopt -o filenames; COMPREPLY+=($(compgen -f -- \"$cur\")); ";
  if (values.folders) code += "compopt -o filenames; COMPREPLY+=($(compgen -d -- \"$cur\")); ";
  return code;
}

std::string bash(const CLI::App& app) {
  std::string text =
      "# bash completion of lamella. Load it with: source <(lamella completion bash)\n"
      "_lamella() {\n"
      "  local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD-1]}\n"
      "  COMPREPLY=()\n"
      "  if ((COMP_CWORD == 1)); then\n";
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  for (const Word& word : words_of(app))
    names.insert(names.end(), word.spellings.begin(), word.spellings.end());
  text += fmt::format(
      "    COMPREPLY=($(compgen -W '{}' -- \"$cur\"))\n    return\n  fi\n"
      "  case ${{COMP_WORDS[1]}} in\n",
      joined(names, " "));
  for (const CLI::App* command : app.get_subcommands({})) {
    text += fmt::format("  {})\n    case $prev in\n", command->get_name());
    std::vector<std::string> options;
    std::string arguments;
    for (const Word& word : words_of(*command)) {
      options.insert(options.end(), word.spellings.begin(), word.spellings.end());
      if (word.spellings.empty())
        arguments += bash_values(word.values);
      else if (word.takes_value)
        text += fmt::format("    {}) {}return ;;\n", joined(word.spellings, "|"),
                            bash_values(word.values));
    }
    text += fmt::format(
        "    esac\n    if [[ $cur == -* ]]; then COMPREPLY=($(compgen -W '{}' -- \"$cur\")); "
        "return; fi\n    {}:\n    ;;\n",
        joined(options, " "), arguments);
  }
  return text + "  esac\n}\ncomplete -F _lamella lamella\n";
}

// Inside single quotes, where zsh's _arguments gives ":" and brackets a meaning.
std::string zsh_quoted(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\'')
      out += "'\\''";
    else if (c == ':' || c == '[' || c == ']')
      out += std::string("\\") + c;
    else
      out += c;
  }
  return out;
}

// An action of _arguments: several sources are tried together.
std::string zsh_action(const Values& values) {
  std::string code;
  if (!values.words.empty()) code += "compadd -- " + joined(values.words, " ") + "; ";
  if (values.files) code += "_files; ";
  if (values.folders) code += "_files -/; ";
  return "{ " + code + "}";
}

std::string zsh(const CLI::App& app) {
  std::string text =
      "#compdef lamella\n"
      "# zsh completion of lamella. Put it as _lamella into a folder of $fpath, or load it with:\n"
      "# source <(lamella completion zsh)\n"
      "_lamella() {\n"
      "  if ((CURRENT == 2)); then\n    local -a commands=(\n";
  for (const CLI::App* command : app.get_subcommands({}))
    text +=
        fmt::format("      '{}:{}'\n", command->get_name(), zsh_quoted(command->get_description()));
  text += "    )\n    _describe command commands\n";
  for (const Word& word : words_of(app))
    text += "    compadd -- " + joined(word.spellings, " ") + "\n";
  text +=
      "    return\n  fi\n  local command=$words[2]\n  shift words\n  ((CURRENT--))\n  case "
      "$command in\n";
  for (const CLI::App* command : app.get_subcommands({})) {
    text += fmt::format("  {})\n    _arguments", command->get_name());
    for (const Word& word : words_of(*command)) {
      if (word.spellings.empty()) {
        text += fmt::format(" \\\n      '*:{}:{}'", zsh_quoted(word.doc), zsh_action(word.values));
        continue;
      }
      for (const std::string& spelling : word.spellings) {
        text += fmt::format(" \\\n      '{}{}[{}]", word.repeatable ? "*" : "", spelling,
                            zsh_quoted(word.doc));
        if (word.takes_value)
          text += fmt::format(": :{}", word.values.empty() ? " " : zsh_action(word.values));
        text += "'";
      }
    }
    text += "\n    ;;\n";
  }
  return text +
         "  esac\n}\n"
         "if [[ $funcstack[1] == _lamella ]]; then _lamella \"$@\"; else compdef _lamella lamella; "
         "fi\n";
}

}  // namespace

std::string completion_script(const CLI::App& app, std::string_view shell) {
  return shell == "zsh" ? zsh(app) : bash(app);
}

}  // namespace lamella
