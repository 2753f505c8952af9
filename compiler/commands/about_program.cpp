#include <cstdio>
#include <memory>
#include <sstream>
#include <string>

#include "compiler/cli/help_text.h"
#include "compiler/cli/verb.h"
#include "compiler/commands/commands.h"
#include "compiler/driver/configuration.h"
#include "compiler/driver/pipelines.h"
#include "formats/text/quoted_text.h"

// Verbs about the program itself: its passes and its command line.

namespace sightline {
namespace {

std::string all_names(const std::vector<Flag>& flags) {
  std::vector<std::string> names;
  for (const Flag& flag : flags) names.push_back(joined(names_of(flag), " "));
  return joined(names, " ");
}

// What may stand behind a flag that takes a value, as branches over the word before.
std::string bash_values(const Verb& verb) {
  std::string text;
  for (const Flag& flag : shown_flags(verb)) {
    if (!takes_value(flag) || !flag.bare_value.empty()) continue;
    text += concat("        ", joined(names_of(flag), "|"), ") ");
    text += flag.choices.empty() ? "return ;;\n"
                                 : concat("words='", joined(flag.choices, " "), "' ;;\n");
  }
  if (text.empty()) return text;
  return concat("      case $before in\n", text, "      esac\n");
}

std::string bash_branch(const Verb& verb) {
  std::string text =
      concat("    ", verb.name, ")\n      flags='", all_names(shown_flags(verb)), "'\n");
  for (const Positional& positional : verb.positionals) {
    if (positional.choices.empty()) continue;
    text += concat("      words='", joined(positional.choices, " "), "'\n");
  }
  return concat(text, bash_values(verb), "      ;;\n");
}

// _arguments takes brackets and colons for its own.
std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') result += '\\';
    result += c == '\n' ? ' ' : c;
  }
  return result;
}

// Nothing is offered for a value that is neither a choice nor a file.
std::string zsh_action(const std::string& value, const std::vector<std::string>& choices) {
  if (!choices.empty()) return concat("(", joined(choices, " "), ")");
  return value == "FILE" || value == "FOLDER" ? "_files" : " ";
}

// ":FILE:_files:FILE:_files", one pair for each word.
std::string zsh_values(const Flag& flag) {
  std::string text;
  std::istringstream words(flag.value);
  for (std::string word; words >> word;)
    text += concat(":", word, ":", zsh_action(word, flag.choices));
  return text;
}

// '(-o --output)'{-o,--output}'[help]:FILE:_files', '*--set[help]:KEY=VALUE: '
std::string zsh_flag(const Flag& flag) {
  const std::vector<std::string> names = names_of(flag);
  const std::string help = concat("[", escaped(flag.help), "]");
  if (!flag.bare_value.empty()) {
    return shell_word(concat(long_name(flag), "=-", help, ":", zsh_values(flag)));
  }
  const std::string behind = help + zsh_values(flag);
  if (is_list(flag.target)) return shell_word(concat("*", long_name(flag), behind));
  if (names.size() == 1) return shell_word(long_name(flag) + behind);
  return concat(shell_word("(" + joined(names, " ") + ")"), "{", joined(names, ","), "}",
                shell_word(behind));
}

std::string zsh_branch(const Verb& verb) {
  std::string text = concat("    ", verb.name, ")\n      _arguments -s -S");
  for (const Flag& flag : shown_flags(verb)) text += " \\\n        " + zsh_flag(flag);
  int place = 1;
  for (const Positional& positional : verb.positionals) {
    const std::string where = is_list(positional.target) ? "*" : std::to_string(place++);
    // A positional that is no choice may be a file.
    const std::string action = zsh_action("FILE", positional.choices);
    text += " \\\n        " + shell_word(concat(where, ":", escaped(positional.name), ":", action));
  }
  return text + "\n      ;;\n";
}

// A script to be sourced by bash 4 or later. Needs nothing but its builtins; where a file may stand
// it leaves the word to readline.
std::string bash_completion(const Program& program) {
  const std::string function = "_" + program.name;
  std::string text = concat("# Completion of ", program.name, " in bash; made by `", program.name,
                            " completion bash`.\n", function, "() {\n");
  text += concat(
      "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} verb= i\n"
      "  local flags= words=\n"
      "  COMPREPLY=()\n"
      "  for ((i = 1; i < COMP_CWORD; ++i)); do\n"
      "    if [[ ${COMP_WORDS[i]} != -* ]]; then verb=${COMP_WORDS[i]}; break; fi\n"
      "  done\n"
      "  case $verb in\n"
      "    '')\n"
      "      flags='",
      all_names(flags_without_verb()), "'\n      words='", joined(verb_names(program), " "),
      "'\n      ;;\n");
  for (const Verb& verb : program.verbs) text += bash_branch(verb);
  text +=
      "  esac\n"
      "  if [[ $word == -* ]]; then words=$flags; fi\n"
      "  if [[ -n $words ]]; then COMPREPLY=($(compgen -W \"$words\" -- \"$word\")); fi\n"
      "}\n";
  return concat(text, "complete -o default -F ", function, " ", program.name, "\n");
}

// A completion function for zsh, to be sourced after compinit or put into a folder of $fpath as
// _sightline.
std::string zsh_completion(const Program& program) {
  const std::string function = "_" + program.name;
  std::string text =
      concat("#compdef ", program.name, "\n# Completion in zsh; made by `", program.name,
             " completion zsh`.\n", function, "() {\n  local -a verbs\n  verbs=(\n");
  for (const Verb& verb : program.verbs) {
    text += concat("    ", shell_word(verb.name + ":" + escaped(verb.summary)), "\n");
  }
  text +=
      "  )\n"
      "  if ((CURRENT == 2)) && [[ $words[2] != -* ]]; then\n"
      "    _describe -t commands verb verbs\n"
      "    return\n"
      "  fi\n"
      "  if ((CURRENT == 2)); then\n"
      "    _arguments -s";
  for (const Flag& flag : flags_without_verb()) text += " \\\n      " + zsh_flag(flag);
  text +=
      "\n    return\n"
      "  fi\n"
      "  shift words\n"
      "  ((CURRENT--))\n"
      "  case $words[1] in\n";
  for (const Verb& verb : program.verbs) text += zsh_branch(verb);
  text += "  esac\n}\n";
  // Loaded from $fpath the file is the body of the function; sourced it must register it.
  return concat(text, "if [[ $funcstack[1] == ", function, " ]]; then ", function,
                " \"$@\"; else compdef ", function, " ", program.name, "; fi\n");
}

struct PassesFlags {
  bool print_schema = false;
  bool print_config = false;
};

void print_passes() {
  CompileConfig config;  // with a localization drive, so that every pass is in it
  config.mapping.scans = "mapping/scans";
  config.localization.scans = "drive/scans";
  const Plan plan = compile_plan(config).plan;
  for (const PassStep& step : plan.steps()) {
    std::string inputs;
    for (const std::size_t input : step.inputs) {
      inputs += (inputs.empty() ? "" : ", ") + plan.artifact({input}).name;
    }
    std::printf("%s (version %u)\n  %s -> %s\n", step.name.c_str(), step.version, inputs.c_str(),
                plan.artifact({step.output}).name.c_str());
    for (const auto& [name, value] : step.options) {
      std::printf("    %s = %s\n", name.c_str(), value.c_str());
    }
  }
}

void run_passes(const PassesFlags& flags) {
  CompileConfig config;
  if (flags.print_schema) {
    std::fputs(to_json_schema(published_sections(config)).c_str(), stdout);
  } else if (flags.print_config) {
    std::fputs(to_yaml(published_sections(config)).c_str(), stdout);
  } else {
    print_passes();
  }
}

}  // namespace

Verb completion_verb() {
  const auto shell = std::make_shared<std::string>();
  Verb verb;
  verb.name = "completion";
  verb.summary = "Print a script that completes verbs, flags and values in a shell";
  verb.examples = {
      "source <(sightline completion bash)",
      "sightline completion bash > ~/.local/share/bash-completion/completions/sightline",
      "sightline completion zsh > ~/.zfunc/_sightline"};
  verb.positionals = {{.name = "SHELL",
                       .help = "Which shell reads the script",
                       .target = shell.get(),
                       .choices = {"bash", "zsh"}}};
  verb.run = [shell]() -> Result<int> {
    const Program program = sightline_program();
    const std::string script =
        *shell == "bash" ? bash_completion(program) : zsh_completion(program);
    std::fputs(script.c_str(), stdout);
    return 0;
  };
  return verb;
}

Verb man_verb() {
  Verb verb;
  verb.name = "man";
  verb.summary = "Print the manual page";
  verb.examples = {"sightline man | man -l -",
                   "sightline man > ~/.local/share/man/man1/sightline.1"};
  verb.run = []() -> Result<int> {
    std::fputs(man_page(sightline_program()).c_str(), stdout);
    return 0;
  };
  return verb;
}

Verb help_verb(std::vector<std::string> verbs) {
  verbs.emplace_back("help");
  const auto name = std::make_shared<std::string>();
  Verb verb;
  verb.name = "help";
  verb.summary = "Explain a verb with examples, or list all verbs";
  verb.details = "`sightline help VERB` prints the same as `sightline VERB --help`.";
  verb.examples = {"sightline help", "sightline help compile"};
  verb.positionals = {{.name = "VERB",
                       .help = "The verb to explain",
                       .target = name.get(),
                       .choices = verbs,
                       .is_required = false}};
  verb.run = [name]() -> Result<int> {
    const Program program = sightline_program();
    const Verb* const found = find_verb(program, *name);
    const std::string text =
        found == nullptr ? help_text(program) : help_text(concat(program.name, " ", *name), *found);
    std::fputs(text.c_str(), stdout);
    return 0;
  };
  return verb;
}

Verb passes_verb() {
  const auto flags = std::make_shared<PassesFlags>();
  Verb verb;
  verb.name = "passes";
  verb.summary = "List the passes of a compile in their order";
  verb.examples = {"sightline passes                         # names, inputs, outputs, options",
                   "sightline passes --schema > config.json  # JSON Schema of the configuration",
                   "sightline passes --config > drive.yaml   # a configuration with every default"};
  verb.flags = {{.names = "--schema",
                 .help = "Print the JSON Schema of the configuration",
                 .target = &flags->print_schema},
                {.names = "--config",
                 .help = "Print a commented configuration with every default",
                 .target = &flags->print_config,
                 .excludes = "--schema"}};
  verb.run = [flags]() -> Result<int> {
    run_passes(*flags);
    return 0;
  };
  return verb;
}

}  // namespace sightline
