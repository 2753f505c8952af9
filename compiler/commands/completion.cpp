#include <cstdio>
#include <memory>
#include <sstream>
#include <string>

#include "compiler/cli/verb.h"
#include "compiler/commands/commands.h"
#include "compiler/config/config_file.h"
#include "compiler/driver/configuration.h"
#include "formats/text/quoted_text.h"

// Scripts that complete the command line in a shell, made from its description.

namespace sightline {
namespace {

// "mapping.scans=" and so on: what --set takes, up to the value.
std::vector<std::string> keys_of_configuration() {
  CompileConfig config;
  std::vector<std::string> keys;
  for (const ConfigSection& section : published_sections(config)) {
    for (const OptionField& field : section.fields) {
      keys.push_back(concat(section.name, ".", field.name, "="));
    }
  }
  return keys;
}

bool takes_key(const Flag& flag) { return long_name(flag) == "--set"; }

bool takes_path(const std::string& value) { return value == "FILE" || value == "FOLDER"; }

std::string all_names(const std::vector<Flag>& flags) {
  std::vector<std::string> names;
  for (const Flag& flag : flags) names.push_back(joined(names_of(flag), " "));
  return joined(names, " ");
}

// "'cluster plan'|plan": a verb and its old names.
std::string shell_pattern(const Program& program, const Verb& verb) {
  std::string text = family_of(verb).empty() ? verb.name : concat("'", verb.name, "'");
  for (const auto& [alias, name] : program.aliases) {
    const bool is_family = alias == family_of(verb);
    if (name == verb.name && !is_family) text += "|" + alias;
  }
  return text;
}

std::string family_pattern(const Program& program) {
  std::vector<std::string> names;
  for (const Family& family : program.families) names.push_back(family.name);
  return joined(names, "|");
}

// Values of flags, as branches over the word before.
std::string bash_values(const Verb& verb) {
  std::string text;
  for (const Flag& flag : shown_flags(verb)) {
    if (!takes_value(flag) || !flag.bare_value.empty()) continue;
    text += concat("        ", joined(names_of(flag), "|"), ") ");
    if (takes_key(flag)) {
      text += "words=$keys; compopt -o nospace 2> /dev/null || true ;;\n";
    } else if (flag.choices.empty()) {
      text += "return ;;\n";
    } else {
      text += concat("words='", joined(flag.choices, " "), "' ;;\n");
    }
  }
  if (text.empty()) return text;
  return concat("      case $before in\n", text, "      esac\n");
}

std::string bash_branch(const Program& program, const Verb& verb) {
  std::string text = concat("    ", shell_pattern(program, verb), ")\n      flags='",
                            all_names(shown_flags(verb)), "'\n");
  for (const Positional& positional : verb.positionals) {
    if (positional.choices.empty()) continue;
    text += concat("      words='", joined(positional.choices, " "), "'\n");
  }
  return concat(text, bash_values(verb), "      ;;\n");
}

// A script to be sourced by bash 4 or later. It needs only builtins, and leaves files to readline.
std::string bash_completion(const Program& program) {
  const std::string function = "_" + program.name;
  std::string text = concat("# Completion of ", program.name, " in bash; made by `", program.name,
                            " completion bash`.\n", function, "() {\n");
  text += concat(
      "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} verb= i\n"
      "  local flags= words=\n  local keys='",
      joined(keys_of_configuration(), " "),
      "'\n"
      "  COMPREPLY=()\n"
      "  for ((i = 1; i < COMP_CWORD; ++i)); do\n"
      "    if [[ ${COMP_WORDS[i]} != -* ]]; then verb=${COMP_WORDS[i]}; break; fi\n"
      "  done\n"
      "  case $verb in\n    ",
      family_pattern(program),
      ")\n"
      "      if ((i + 1 < COMP_CWORD)); then verb+=\" ${COMP_WORDS[i + 1]}\"; fi\n"
      "      ;;\n"
      "  esac\n"
      "  case $verb in\n"
      "    '')\n"
      "      flags='",
      all_names(flags_without_verb()), "'\n      words='", joined(top_names(program), " "),
      "'\n      ;;\n");
  for (const Family& family : program.families) {
    text += concat("    ", family.name, ")\n      flags='-h --help'\n      words='",
                   joined(names_in(program, family.name), " "), "'\n      ;;\n");
  }
  for (const Verb& verb : program.verbs) text += bash_branch(program, verb);
  text +=
      "  esac\n"
      "  if [[ $word == -* ]]; then words=$flags; fi\n"
      "  if [[ -n $words ]]; then COMPREPLY=($(compgen -W \"$words\" -- \"$word\")); fi\n"
      "}\n";
  return concat(text, "complete -o default -F ", function, " ", program.name, "\n");
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
  return takes_path(value) ? "_files" : " ";
}

// ":FILE:_files:FILE:_files", one pair for each word.
std::string zsh_values(const Flag& flag) {
  if (takes_key(flag)) return concat(":", flag.value, ":_sightline_keys");
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
  const std::string value = help + zsh_values(flag);
  if (is_list(flag.target)) return shell_word(concat("*", long_name(flag), value));
  if (names.size() == 1) return shell_word(long_name(flag) + value);
  return concat(shell_word("(" + joined(names, " ") + ")"), "{", joined(names, ","), "}",
                shell_word(value));
}

std::string zsh_branch(const Program& program, const Verb& verb) {
  std::string text = concat("    ", shell_pattern(program, verb), ")\n      _arguments -s -S");
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

// "    verbs=('plan:Plan a compile ...')": of a family, or the words at the top for "".
std::string zsh_verbs(const Program& program, const std::string& family) {
  std::string text = "    verbs=(\n";
  std::string last;
  for (const Verb& verb : program.verbs) {
    const std::string own = family_of(verb);
    std::string name = verb.name;
    std::string summary = verb.summary;
    if (family.empty() && !own.empty()) {
      if (own == last) continue;
      last = name = own;
      for (const Family& each : program.families) {
        if (each.name == own) summary = each.summary;
      }
    } else if (own != family) {
      continue;
    } else if (!family.empty()) {
      name = name.substr(family.size() + 1);
    }
    text += concat("      ", shell_word(name + ":" + escaped(summary)), "\n");
  }
  return text + "    )\n";
}

// The second word of a family's verbs joins the first one.
std::string zsh_family(const Program& program, const Family& family) {
  return concat("  if [[ $words[1] == ", family.name, " ]]; then\n",
                zsh_verbs(program, family.name),
                "    if ((CURRENT == 2)); then _describe -t commands verb verbs; return; fi\n"
                "    words[2]=\"$words[1] $words[2]\"\n"
                "    shift words\n"
                "    ((CURRENT--))\n"
                "  fi\n");
}

// A completion function for zsh, to be sourced after compinit or put into a folder of $fpath as
// _sightline.
std::string zsh_completion(const Program& program) {
  const std::string function = "_" + program.name;
  std::string text = concat("#compdef ", program.name, "\n# Completion in zsh; made by `",
                            program.name, " completion zsh`.\n", function, "_keys() {\n",
                            "  compadd -S '' -- ", joined(keys_of_configuration(), " "), "\n}\n",
                            function, "() {\n  local -a verbs\n  if ((CURRENT == 2)) && ",
                            "[[ $words[2] != -* ]]; then\n", zsh_verbs(program, ""));
  text +=
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
      "  ((CURRENT--))\n";
  for (const Family& family : program.families) text += zsh_family(program, family);
  text += "  case $words[1] in\n";
  for (const Verb& verb : program.verbs) text += zsh_branch(program, verb);
  text += "  esac\n}\n";
  // Loaded from $fpath the file is the body of the function; sourced it must register it.
  return concat(text, "if [[ $funcstack[1] == ", function, " ]]; then ", function,
                " \"$@\"; else compdef ", function, " ", program.name, "; fi\n");
}

// fish reads a quote as '...' with \' and \\ in it.
std::string fish_word(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) {
    if (c == '\'' || c == '\\') quoted += '\\';
    quoted += c == '\n' ? ' ' : c;
  }
  return quoted + "'";
}

std::string fish_flag(const std::string& begin, const Flag& flag) {
  std::string text = begin;
  for (const std::string& name : names_of(flag)) {
    text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  }
  if (takes_value(flag) && flag.bare_value.empty()) {
    text += takes_path(flag.value) || flag.value.starts_with("FILE ") ? " -r -F" : " -x";
    if (takes_key(flag)) text += " -a '(__sightline_keys)'";
    if (!flag.choices.empty()) text += " -a " + fish_word(joined(flag.choices, " "));
  }
  return concat(text, " -d ", fish_word(flag.help), "\n");
}

std::string fish_verb(const std::string& complete, const Verb& verb) {
  const std::string begin =
      concat(complete, " -n ", fish_word(concat("__sightline_is ", fish_word(verb.name))));
  std::string text;
  for (const Flag& flag : shown_flags(verb)) text += fish_flag(begin, flag);
  for (const Positional& positional : verb.positionals) {
    text += positional.choices.empty()
                ? concat(begin, " -F\n")
                : concat(begin, " -a ", fish_word(joined(positional.choices, " ")), "\n");
  }
  return text;
}

// Old names call their verbs too.
std::string fish_functions(const Program& program) {
  std::string text =
      "# The verb on the command line: one word, or two of a family.\n"
      "function __sightline_verb\n"
      "  set -l verb\n"
      "  for word in (commandline -opc)[2..-1]\n"
      "    if string match -q -- '-*' $word; continue; end\n"
      "    set -a verb $word\n"
      "    if test (count $verb) -eq 1; and contains -- $word";
  for (const Family& family : program.families) text += " " + family.name;
  text +=
      "; continue; end\n"
      "    break\n"
      "  end\n"
      "  switch \"$verb\"\n";
  for (const auto& [alias, name] : program.aliases) {
    if (name.starts_with(alias + " ")) continue;  // a family
    text += concat("    case ", alias, "\n      set verb ", fish_word(name), "\n");
  }
  return concat(text,
                "  end\n"
                "  echo \"$verb\"\n"
                "end\n"
                "function __sightline_is\n"
                "  test (__sightline_verb) = $argv[1]\n"
                "end\n"
                "function __sightline_keys\n"
                "  printf '%s\\n' ",
                joined(keys_of_configuration(), " "), "\nend\n");
}

// A script to be sourced by fish 3 or later, or put into its folder of completions.
std::string fish_completion(const Program& program) {
  const std::string complete = "complete -c " + program.name;
  std::string text = concat("# Completion in fish; made by `", program.name, " completion fish`.\n",
                            fish_functions(program), complete, " -f\n");
  const std::string at_top = concat(complete, " -n '__sightline_is \"\"'");
  for (const Flag& flag : flags_without_verb()) text += fish_flag(at_top, flag);
  for (const Verb& verb : program.verbs) {
    if (!family_of(verb).empty()) continue;
    text += concat(at_top, " -a ", verb.name, " -d ", fish_word(verb.summary), "\n");
  }
  for (const Family& family : program.families) {
    text += concat(at_top, " -a ", family.name, " -d ", fish_word(family.summary), "\n");
    const std::string begin = concat(complete, " -n '__sightline_is ", family.name, "'");
    for (const Verb& verb : program.verbs) {
      if (family_of(verb) != family.name) continue;
      text += concat(begin, " -a ", verb.name.substr(family.name.size() + 1), " -d ",
                     fish_word(verb.summary), "\n");
    }
  }
  for (const Verb& verb : program.verbs) text += fish_verb(complete, verb);
  return text;
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
      "sightline completion zsh > ~/.zfunc/_sightline",
      "sightline completion fish > ~/.config/fish/completions/sightline.fish"};
  verb.positionals = {{.name = "SHELL",
                       .help = "The shell that reads the script",
                       .target = shell.get(),
                       .choices = {"bash", "zsh", "fish"}}};
  verb.run = [shell]() -> Result<int> {
    const Program program = sightline_program();
    const std::string script = *shell == "bash"  ? bash_completion(program)
                               : *shell == "zsh" ? zsh_completion(program)
                                                 : fish_completion(program);
    std::fputs(script.c_str(), stdout);
    return 0;
  };
  return verb;
}

}  // namespace sightline
