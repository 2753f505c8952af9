#include "compiler/cli/man_page.h"

#include <algorithm>
#include <map>

#include "compiler/cli/flag_value.h"
#include "compiler/cli/help_text.h"
#include "formats/base/error.h"

namespace sightline {
namespace {

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
    result += ".PP\n" + roff(text.substr(begin, end - begin)) + "\n";
    begin = end + 2;
  }
  return result;
}

// As they are written.
std::string literal_lines(const std::vector<std::string>& lines) {
  std::string text = ".RS 2\n.nf\n";
  for (const std::string& line : lines) text += roff(line) + "\n";
  return text + ".fi\n.RE\n";
}

// Facts stand in parentheses behind the help.
std::string with_facts(const Flag& flag) {
  const std::string facts = facts_of(flag);
  return roff(flag.help + (facts.empty() ? "" : " (" + facts + ")")) + ".\n";
}

std::string flag_text(const Flag& flag) {
  std::string names;
  for (const std::string& name : names_of(flag)) {
    names += (names.empty() ? "" : ", ") + ("\\fB" + roff(name) + "\\fR");
  }
  if (!flag.bare_value.empty()) {
    names += "[=\\fI" + roff(flag.value) + "\\fR]";
  } else if (takes_value(flag)) {
    names += " \\fI" + roff(flag.value) + "\\fR";
  }
  return ".TP\n" + names + "\n" + with_facts(flag);
}

std::string verb_text(const Program& program, const Verb& verb) {
  const std::string command = program.name + " " + verb.name;
  std::string text = ".SS " + roff(verb.name) + "\n" + roff(usage_text(command, verb)) + "\n.PP\n" +
                     roff(verb.summary) + ".\n";
  for (const Positional& positional : verb.positionals) {
    text += ".TP\n\\fI" + roff(positional.name) + "\\fR\n" + with_facts(as_flag(positional));
  }
  for (const Flag& flag : shown_flags(verb)) text += flag_text(flag);
  text += paragraphs(verb.details);
  return text + ".PP\nExamples:\n" + literal_lines(verb.examples);
}

// 64 with the names of its failures, and so on.
std::string exit_statuses() {
  std::map<int, std::string> names;
  for (const ErrorCodeInfo& info : all_error_codes()) {
    std::string& list = names[exit_status(info.code)];
    list += (list.empty() ? "" : ", ") +
            ("SL" + std::to_string(static_cast<int>(info.code)) + " " + std::string(info.name));
  }
  const std::map<int, std::string> meaning = {
      {64, "usage: the command line or the configuration"},
      {65, "input: recordings, poses, anything that was brought"},
      {66, "version: written by a program that this one does not understand"},
      {67, "corrupt: a file of sightline's own, damaged"},
      {68, "signature: a file that is not what was signed, or by a key that is not trusted"},
      {69, "gate: a rule of the gate was broken"},
      {74, "system: the machine said no"},
      {75, "incomplete: stopped before the end; what was done is kept"}};
  std::string text = ".TP\n0\nDone.\n";
  for (const auto& [status, what] : meaning) {
    text += ".TP\n" + std::to_string(status) + "\n" + roff(what) + ".\n";
    if (names.contains(status)) text += roff(names[status]) + ".\n";
  }
  return text +
         ".PP\n\\fBsightline diff\\fR alone exits 0 where maps are the same, 1 where they "
         "differ, 2 in trouble.\n";
}

}  // namespace

std::string man_page(const Program& program) {
  std::string text =
      ".TH SIGHTLINE 1 \"\" \"sightline " + program.version + "\" \"User Commands\"\n.ad l\n";
  text += ".SH NAME\n" + roff(program.name) +
          " \\- compile recorded drives into a map of how far a vehicle must look\n";
  text += ".SH SYNOPSIS\n";
  for (const Verb& verb : program.verbs) {
    text += roff(usage_text(program.name + " " + verb.name, verb)) + "\n.br\n";
  }
  text += ".SH DESCRIPTION\n" + roff(program.summary) + "\n";
  text +=
      ".PP\nData goes to stdout, log and progress to stderr. Outputs appear whole or not at all "
      "and are not overwritten without \\fB\\-\\-force\\fR. Finished passes are cached beside the "
      "configuration.\n";
  text += ".PP\nBegin with a folder of recordings:\n" + literal_lines(program.first_steps);
  text += ".SH COMMANDS\n";
  for (const Verb& verb : program.verbs) text += verb_text(program, verb);
  text += ".SH EXIT STATUS\n" + exit_statuses();
  text +=
      ".SH ENVIRONMENT\n"
      ".TP\nNO_COLOR\nWhere this is set and not empty, nothing is printed in colour.\n"
      ".SH FILES\n"
      ".TP\n\\fI*.yaml\\fR\nA configuration; its JSON Schema is printed by \\fBsightline passes "
      "\\-\\-schema\\fR.\n"
      ".TP\n\\fI*.slmap\\fR\nA compiled map.\n"
      ".TP\n\\fI*.slmap.provenance.json\\fR\nHow that map came to be: times, host, command line, "
      "configuration.\n"
      ".TP\n\\fI*.slmodel\\fR\nA trained error model.\n"
      ".TP\n\\fI.sightline\\-cache/\\fR\nFinished passes, beside the configuration; may be removed "
      "at any time.\n";
  return text;
}

}  // namespace sightline
