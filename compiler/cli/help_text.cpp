#include "compiler/cli/help_text.h"

#include <algorithm>
#include <sstream>

#include "compiler/cli/flag_value.h"

namespace sightline {
namespace {

constexpr std::size_t kWidestTitle = 28;  // a longer one has a line of its own

// Fills lines from `column` to kHelpColumns. The first line is taken to have reached `column`.
std::string filled(const std::string& text, std::size_t column) {
  std::istringstream words(text);
  std::string result;
  std::size_t at = column;
  for (std::string word; words >> word;) {
    if (at > column && at + 1 + word.size() > kHelpColumns) {
      result += "\n" + std::string(column, ' ');
      at = column;
    }
    if (at > column) result += " ";
    at += word.size() + (at > column ? 1 : 0);
    result += word;
  }
  return result + "\n";
}

// Paragraphs between empty lines, each filled.
std::string filled_paragraphs(const std::string& text) {
  std::string result;
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find("\n\n", begin), text.size());
    result += "\n" + filled(text.substr(begin, end - begin), 0);
    begin = end + 2;
  }
  return result;
}

// A title with its explanation in a second column.
struct Entry {
  std::string title;
  std::string text;
};

std::size_t width_of(const std::vector<Entry>& entries) {
  std::size_t width = 0;
  for (const Entry& entry : entries) {
    if (entry.title.size() <= kWidestTitle) width = std::max(width, entry.title.size());
  }
  return width;
}

std::string two_columns(const std::vector<Entry>& entries, std::size_t width) {
  const std::size_t column = width + 4;
  std::string text;
  for (const Entry& entry : entries) {
    text += "  " + entry.title;
    const bool is_wide = entry.title.size() > width;
    text += is_wide ? "\n" + std::string(column, ' ')
                    : std::string(column - 2 - entry.title.size(), ' ');
    text += filled(entry.text, column);
  }
  return text;
}

Entry entry_of(const Flag& flag) {
  const bool has_letter = names_of(flag).size() > 1;
  const std::string facts = facts_of(flag);
  return {(has_letter ? "" : "    ") + flag_title(flag),
          flag.help + (facts.empty() ? "" : " (" + facts + ")")};
}

std::string indented_lines(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += "  " + line + "\n";
  return text;
}

// Verbs of a group stand together in the program.
std::string verbs_by_group(const Program& program) {
  std::vector<Entry> entries;
  for (const Verb& verb : program.verbs) entries.push_back({verb.name, verb.summary});
  const std::size_t width = width_of(entries);
  std::string text;
  std::string group;
  for (const Verb& verb : program.verbs) {
    if (verb.group != group) text += "\n" + verb.group + ":\n";
    group = verb.group;
    text += two_columns({{verb.name, verb.summary}}, width);
  }
  return text;
}

std::string option_list(const std::vector<Flag>& flags) {
  std::vector<Entry> entries;
  for (const Flag& flag : flags) entries.push_back(entry_of(flag));
  return "\nOptions:\n" + two_columns(entries, width_of(entries));
}

}  // namespace

std::string flag_title(const Flag& flag) {
  std::string text;
  for (const std::string& name : names_of(flag)) text += (text.empty() ? "" : ", ") + name;
  if (!flag.bare_value.empty()) return text + "[=" + flag.value + "]";
  return takes_value(flag) ? text + " " + flag.value : text;
}

std::string facts_of(const Flag& flag) {
  std::vector<std::string> facts;
  if (flag.is_required && !flag.names.empty()) facts.emplace_back("required");
  if (!flag.choices.empty()) facts.push_back(expected_text(flag));
  if (flag.minimum && flag.maximum) facts.push_back(expected_text(flag));
  if (const std::string value = default_text(flag); !value.empty()) {
    facts.push_back("default: " + value);
  }
  if (is_list(flag.target) && !flag.names.empty()) facts.emplace_back("may be repeated");
  std::string text;
  for (const std::string& fact : facts) text += (text.empty() ? "" : "; ") + fact;
  return text;
}

std::string usage_text(const std::string& command, const Verb& verb) {
  std::string text = command + " [OPTION]...";
  for (const Flag& flag : verb.flags) {
    if (flag.is_required) text += " " + long_name(flag) + " " + flag.value;
  }
  for (const Positional& positional : verb.positionals) {
    const std::string name = positional.name + (is_list(positional.target) ? "..." : "");
    text += positional.is_required ? " " + name : " [" + name + "]";
  }
  return text;
}

std::string help_text(const std::string& command, const Verb& verb) {
  std::string text = "Usage: " + usage_text(command, verb) + "\n\n" + verb.summary + "\n";
  std::vector<Entry> arguments;
  for (const Positional& positional : verb.positionals) {
    arguments.push_back({positional.name, entry_of(as_flag(positional)).text});
  }
  if (!arguments.empty()) {
    text += "\nArguments:\n" + two_columns(arguments, width_of(arguments));
  }
  text += option_list(shown_flags(verb));
  text += filled_paragraphs(verb.details);
  return text + "\nExamples:\n" + indented_lines(verb.examples);
}

std::string help_text(const Program& program) {
  std::string text = filled(program.summary, 0) + "\nUsage: " + program.name +
                     " VERB [OPTION]...\n\nBegin with a folder of recordings:\n" +
                     indented_lines(program.first_steps) + verbs_by_group(program) +
                     option_list(flags_without_verb());
  text += "\n`" + program.name + " help VERB` explains a verb with examples, `" + program.name +
          " man | man -l -` all of them.\n";
  return text + filled_paragraphs(program.details);
}

}  // namespace sightline
