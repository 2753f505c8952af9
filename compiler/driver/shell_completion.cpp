#include "compiler/driver/shell_completion.h"

#include <numeric>

namespace sightline {
namespace {

std::string joined(const std::vector<std::string>& words, const std::string& between) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : between) + word;
  return text;
}

std::string all_names(const std::vector<CommandFlag>& flags) {
  std::vector<std::string> names;
  for (const CommandFlag& flag : flags) names.push_back(joined(flag.names, " "));
  return joined(names, " ");
}

// What may stand behind a flag that takes a value, as branches over the word before.
std::string bash_values(const CommandVerb& verb) {
  std::string text;
  for (const CommandFlag& flag : verb.flags) {
    if (flag.value.empty()) continue;
    text += "        " + joined(flag.names, "|") + ") ";
    text += flag.choices.empty() ? "return ;;\n"
                                 : "words='" + joined(flag.choices, " ") + "' ;;\n";
  }
  if (text.empty()) return text;
  return "      case $before in\n" + text + "      esac\n";
}

std::string bash_branch(const CommandVerb& verb) {
  std::string text = "    " + verb.name + ")\n      flags='" + all_names(verb.flags) + "'\n";
  for (const CommandArgument& argument : verb.arguments) {
    if (!argument.choices.empty()) text += "      words='" + joined(argument.choices, " ") + "'\n";
  }
  return text + bash_values(verb) + "      ;;\n";
}

// A word in single quotes.
std::string in_quotes(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return result + "'";
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

std::string zsh_action(const std::vector<std::string>& choices) {
  return choices.empty() ? "_files" : "(" + joined(choices, " ") + ")";
}

// '(-o --output)'{-o,--output}'[help]:value:_files'
std::string zsh_flag(const CommandFlag& flag) {
  std::string behind = "[" + escaped(flag.help) + "]";
  if (!flag.value.empty()) behind += ":" + flag.value + ":" + zsh_action(flag.choices);
  if (flag.names.size() == 1) return in_quotes("*" + flag.names.front() + behind);
  return in_quotes("(" + joined(flag.names, " ") + ")") + "{" + joined(flag.names, ",") + "}" +
         in_quotes(behind);
}

std::string zsh_branch(const CommandVerb& verb) {
  std::string text = "    " + verb.name + ")\n      _arguments -s -S";
  for (const CommandFlag& flag : verb.flags) text += " \\\n        " + zsh_flag(flag);
  int place = 1;
  for (const CommandArgument& argument : verb.arguments) {
    const std::string where = argument.is_list ? "*" : std::to_string(place++);
    text += " \\\n        " + in_quotes(where + ":" + escaped(argument.name) + ":" +
                                    zsh_action(argument.choices));
  }
  return text + "\n      ;;\n";
}

std::string verb_names(const CommandTree& tree) {
  return std::accumulate(tree.verbs.begin(), tree.verbs.end(), std::string(),
                         [](const std::string& text, const CommandVerb& verb) {
                           return text + (text.empty() ? "" : " ") + verb.name;
                         });
}

}  // namespace

std::string bash_completion(const CommandTree& tree) {
  const std::string function = "_" + tree.name;
  std::string text = "# Completion of " + tree.name + " in bash; made by `" + tree.name +
                     " completion bash`.\n" + function + "() {\n";
  text +=
      "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} verb= i\n"
      "  local flags= words=\n"
      "  COMPREPLY=()\n"
      "  for ((i = 1; i < COMP_CWORD; ++i)); do\n"
      "    if [[ ${COMP_WORDS[i]} != -* ]]; then verb=${COMP_WORDS[i]}; break; fi\n"
      "  done\n"
      "  case $verb in\n"
      "    '')\n"
      "      flags='" + all_names(tree.flags) + "'\n      words='" + verb_names(tree) +
      "'\n      ;;\n";
  for (const CommandVerb& verb : tree.verbs) text += bash_branch(verb);
  text +=
      "  esac\n"
      "  if [[ $word == -* ]]; then words=$flags; fi\n"
      "  if [[ -n $words ]]; then COMPREPLY=($(compgen -W \"$words\" -- \"$word\")); fi\n"
      "}\n";
  return text + "complete -o default -F " + function + " " + tree.name + "\n";
}

std::string zsh_completion(const CommandTree& tree) {
  const std::string function = "_" + tree.name;
  std::string text = "#compdef " + tree.name + "\n# Completion in zsh; made by `" + tree.name +
                     " completion zsh`.\n" + function + "() {\n  local -a verbs\n  verbs=(\n";
  for (const CommandVerb& verb : tree.verbs) {
    text += "    " + in_quotes(verb.name + ":" + escaped(verb.summary)) + "\n";
  }
  text +=
      "  )\n"
      "  if ((CURRENT == 2)) && [[ $words[2] != -* ]]; then\n"
      "    _describe -t commands verb verbs\n"
      "    return\n"
      "  fi\n"
      "  if ((CURRENT == 2)); then\n"
      "    _arguments -s";
  for (const CommandFlag& flag : tree.flags) text += " \\\n      " + zsh_flag(flag);
  text +=
      "\n    return\n"
      "  fi\n"
      "  shift words\n"
      "  ((CURRENT--))\n"
      "  case $words[1] in\n";
  for (const CommandVerb& verb : tree.verbs) text += zsh_branch(verb);
  text += "  esac\n}\n";
  // Loaded from $fpath the file is the body of the function; sourced it must register it.
  return text + "if [[ $funcstack[1] == " + function + " ]]; then " + function +
         " \"$@\"; else compdef " + function + " " + tree.name + "; fi\n";
}

}  // namespace sightline
