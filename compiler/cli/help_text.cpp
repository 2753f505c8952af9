#include "compiler/cli/help_text.h"

#include <algorithm>
#include <map>
#include <sstream>

#include "compiler/cli/verb.h"
#include "formats/base/error.h"

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
          flag.help + (facts.empty() ? "" : concat(" (", facts, ")"))};
}

std::string indented_lines(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += concat("  ", line, "\n");
  return text;
}

// Of a verb of one word, or of the family that a verb is the first of; empty for its others.
std::vector<Entry> top_entry(const Program& program, std::size_t index) {
  const Verb& verb = program.verbs[index];
  const std::string family = family_of(verb);
  if (family.empty()) return {{verb.name, verb.summary}};
  if (index > 0 && family_of(program.verbs[index - 1]) == family) return {};
  const auto found = std::ranges::find(program.families, family, &Family::name);
  return {{family, found == program.families.end() ? "" : found->summary}};
}

// Verbs of a group are neighbours in the program.
std::string verbs_by_group(const Program& program) {
  std::size_t width = 0;
  for (const std::string& name : top_names(program)) width = std::max(width, name.size());
  std::string text;
  std::string group;
  for (std::size_t i = 0; i < program.verbs.size(); ++i) {
    if (program.verbs[i].group != group) text += concat("\n", program.verbs[i].group, ":\n");
    group = program.verbs[i].group;
    text += two_columns(top_entry(program, i), width);
  }
  return text;
}

std::string option_list(const std::vector<Flag>& flags) {
  std::vector<Entry> entries;
  for (const Flag& flag : flags) entries.push_back(entry_of(flag));
  return "\nOptions:\n" + two_columns(entries, width_of(entries));
}

// Text as roff prints it: backslashes, hyphens that are typed as such, and no line that begins like
// a request.
std::string roff(const std::string& text) {
  std::string result;
  for (const char c : text) {
    const bool is_first = result.empty() || result.back() == '\n';
    if (is_first && (c == '.' || c == '\'')) result += "\\&";
    if (c == '\\') {
      result += "\\e";
    } else if (c == '-') {
      result += "\\-";
    } else {
      result += c;
    }
  }
  return result;
}

// Paragraphs between empty lines; roff fills their lines.
std::string paragraphs(const std::string& text) {
  std::string result;
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find("\n\n", begin), text.size());
    result += concat(".PP\n", roff(text.substr(begin, end - begin)), "\n");
    begin = end + 2;
  }
  return result;
}

std::string literal_lines(const std::vector<std::string>& lines) {
  std::string text = ".RS 2\n.nf\n";
  for (const std::string& line : lines) text += roff(line) + "\n";
  return text + ".fi\n.RE\n";
}

// The help, then its facts in parentheses.
std::string with_facts(const Flag& flag) {
  const std::string facts = facts_of(flag);
  return roff(flag.help + (facts.empty() ? "" : concat(" (", facts, ")"))) + ".\n";
}

std::string flag_text(const Flag& flag) {
  std::string names;
  for (const std::string& name : names_of(flag)) {
    names += (names.empty() ? "" : ", ") + (concat("\\fB", roff(name), "\\fR"));
  }
  if (!flag.bare_value.empty()) {
    names += concat("[=\\fI", roff(flag.value), "\\fR]");
  } else if (takes_value(flag)) {
    names += concat(" \\fI", roff(flag.value), "\\fR");
  }
  return concat(".TP\n", names, "\n", with_facts(flag));
}

std::string verb_text(const Program& program, const Verb& verb) {
  const std::string command = concat(program.name, " ", verb.name);
  std::string text = concat(".SS ", roff(verb.name), "\n", roff(usage_text(command, verb)),
                            "\n.PP\n", roff(verb.summary), ".\n");
  for (const Positional& positional : verb.positionals) {
    text += concat(".TP\n\\fI", roff(positional.name), "\\fR\n", with_facts(as_flag(positional)));
  }
  for (const Flag& flag : shown_flags(verb)) text += flag_text(flag);
  text += paragraphs(verb.details);
  return concat(text, ".PP\nExamples:\n", literal_lines(verb.examples));
}

// 64 with the names of its failures, and so on.
std::string exit_statuses() {
  std::map<int, std::string> names;
  for (const ErrorCodeInfo& info : all_error_codes()) {
    std::string& list = names[exit_status(info.code)];
    list +=
        (list.empty() ? "" : ", ") + (concat("SL", static_cast<int>(info.code), " ", info.name));
  }
  const std::map<int, std::string> meaning = {
      {64, "usage: the command line or the configuration"},
      {65, "input: recordings, poses and other files of the user"},
      {66, "version: a file of a version that this program does not read"},
      {67, "corrupt: a damaged file of sightline"},
      {68, "signature: a file that was changed after signing, or a key that is not trusted"},
      {69, "gate: the map breaks a rule"},
      {74, "system: the operating system refused a request"},
      {75, "incomplete: stopped before the end; finished work is kept"}};
  std::string text = ".TP\n0\nDone.\n";
  for (const auto& [status, what] : meaning) {
    text += concat(".TP\n", status, "\n", roff(what), ".\n");
    if (names.contains(status)) text += roff(names[status]) + ".\n";
  }
  return text +
         ".PP\n\\fBsightline diff\\fR alone exits with 0 if the maps are equal, 1 if they "
         "differ, 2 after an error.\n";
}

}  // namespace

std::string flag_title(const Flag& flag) {
  const std::string text = joined(names_of(flag));
  if (!flag.bare_value.empty()) return concat(text, "[=", flag.value, "]");
  return takes_value(flag) ? concat(text, " ", flag.value) : text;
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
  return joined(facts, "; ");
}

std::string usage_text(const std::string& command, const Verb& verb) {
  std::string text = command + " [OPTION]...";
  for (const Flag& flag : verb.flags) {
    if (flag.is_required) text += concat(" ", long_name(flag), " ", flag.value);
  }
  for (const Positional& positional : verb.positionals) {
    const std::string name = positional.name + (is_list(positional.target) ? "..." : "");
    text += positional.is_required ? " " + name : concat(" [", name, "]");
  }
  return text;
}

std::string help_text(const std::string& command, const Verb& verb) {
  std::string text = concat("Usage: ", usage_text(command, verb), "\n\n", verb.summary, "\n");
  std::vector<Entry> arguments;
  for (const Positional& positional : verb.positionals) {
    arguments.push_back({positional.name, entry_of(as_flag(positional)).text});
  }
  if (!arguments.empty()) {
    text += "\nArguments:\n" + two_columns(arguments, width_of(arguments));
  }
  text += option_list(shown_flags(verb));
  text += filled_paragraphs(verb.details);
  return concat(text, "\nExamples:\n", indented_lines(verb.examples));
}

std::string help_text(const Program& program, const Family& family) {
  std::vector<Entry> entries;
  for (const Verb& verb : program.verbs) {
    if (family_of(verb) != family.name) continue;
    entries.push_back({verb.name.substr(family.name.size() + 1), verb.summary});
  }
  const std::string command = concat(program.name, " ", family.name);
  return concat("Usage: ", command, " VERB [OPTION]...\n\n", family.summary, "\n\nVerbs:\n",
                two_columns(entries, width_of(entries)), "\n`", command,
                " VERB --help` explains a verb with examples.\n");
}

std::string help_text(const Program& program) {
  std::string text = concat(filled(program.summary, 0), "\nUsage: ", program.name,
                            " VERB [OPTION]...\n\nFirst steps, with a folder of recordings:\n",
                            indented_lines(program.first_steps), verbs_by_group(program),
                            option_list(flags_without_verb()));
  text += concat("\n`", program.name, " help VERB` explains a verb with examples; `", program.name,
                 " man | man -l -` shows the manual.\n");
  return text + filled_paragraphs(program.details);
}

std::string man_page(const Program& program) {
  std::string text =
      concat(".TH SIGHTLINE 1 \"\" \"sightline ", program.version, "\" \"User Commands\"\n.ad l\n");
  text += concat(".SH NAME\n", roff(program.name),
                 " \\- compile recorded drives into a map of how far a vehicle must look\n");
  text += ".SH SYNOPSIS\n";
  for (const Verb& verb : program.verbs) {
    text += roff(usage_text(concat(program.name, " ", verb.name), verb)) + "\n.br\n";
  }
  text += concat(".SH DESCRIPTION\n", roff(program.summary), "\n");
  text +=
      ".PP\n"
      "Results go to stdout, log and progress to stderr. Output files are written completely or "
      "not at all, and are replaced only with \\fB\\-\\-force\\fR. Finished passes are cached "
      "beside the configuration.\n";
  text += ".PP\nFirst steps, with a folder of recordings:\n" + literal_lines(program.first_steps);
  text += ".SH COMMANDS\n";
  for (const Verb& verb : program.verbs) text += verb_text(program, verb);
  text += ".SH EXIT STATUS\n" + exit_statuses();
  text +=
      ".SH ENVIRONMENT\n"
      ".TP\nNO_COLOR\nIf set and not empty, no colours are printed.\n"
      ".SH FILES\n"
      ".TP\n\\fI*.yaml\\fR\nA configuration; \\fBsightline passes \\-\\-schema\\fR prints its JSON "
      "Schema.\n"
      ".TP\n\\fI*.slmap\\fR\nA compiled map.\n"
      ".TP\n\\fI*.slmap.provenance.json\\fR\nHow the map was made: times, host, command line, "
      "configuration.\n"
      ".TP\n\\fI*.slmodel\\fR\nA trained error model.\n"
      ".TP\n\\fI.sightline\\-cache/\\fR\nThe cache of finished passes; may be removed at any "
      "time.\n";
  return text;
}

}  // namespace sightline
