#include "compiler/driver/man_page.h"

#include <map>
#include <sstream>

#include "compiler/base/error.h"

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

std::vector<std::string> paragraphs(const std::string& text) {
  std::vector<std::string> found;
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find("\n\n", begin), text.size());
    found.push_back(text.substr(begin, end - begin));
    begin = end + 2;
  }
  return found;
}

// "Examples:\n  line\n  line": what is indented stays as it is written.
std::string paragraph_text(const std::string& paragraph) {
  std::istringstream lines(paragraph);
  std::string text = ".PP\n";
  bool is_literal = false;
  for (std::string line; std::getline(lines, line);) {
    const bool is_indented = line.starts_with("  ");
    if (is_indented && !is_literal) text += ".RS 2\n.nf\n";
    if (!is_indented && is_literal) text += ".fi\n.RE\n";
    is_literal = is_indented;
    const std::string shown = is_indented ? line.substr(2) : line;
    text += shown.empty() ? ".sp\n" : roff(shown) + "\n";
  }
  return text + (is_literal ? ".fi\n.RE\n" : "");
}

std::string flag_text(const CommandFlag& flag) {
  std::string names;
  for (const std::string& name : flag.names) {
    names += (names.empty() ? "" : ", ") + ("\\fB" + roff(name) + "\\fR");
  }
  if (!flag.value.empty()) names += " \\fI" + roff(flag.value) + "\\fR";
  std::string text = ".TP\n" + names + "\n" + roff(flag.help.empty() ? "-" : flag.help) + "\n";
  if (flag.choices.empty()) return text;
  text.insert(text.size() - 1, text.ends_with(".\n") ? "" : ".");
  text += "One of";
  for (std::size_t i = 0; i < flag.choices.size(); ++i) {
    text += (i == 0 ? " " : ", ") + roff(flag.choices[i]);
  }
  return text + ".\n";
}

std::string usage(const CommandTree& tree, const CommandVerb& verb) {
  std::string text = "\\fB" + roff(tree.name + " " + verb.name) + "\\fR [\\fIOPTION\\fR]...";
  for (const CommandArgument& argument : verb.arguments) {
    const std::string name =
        "\\fI" + roff(argument.name) + "\\fR" + (argument.is_list ? "..." : "");
    text += argument.is_required ? " " + name : " [" + name + "]";
  }
  return text;
}

std::string verb_text(const CommandTree& tree, const CommandVerb& verb) {
  std::string text = ".SS " + roff(verb.name) + "\n" + usage(tree, verb) + "\n.PP\n" +
                     roff(verb.summary) + ".\n";
  for (const CommandArgument& argument : verb.arguments) {
    text += ".TP\n\\fI" + roff(argument.name) + "\\fR\n" + roff(argument.help) + "\n";
  }
  for (const CommandFlag& flag : verb.flags) text += flag_text(flag);
  for (const std::string& paragraph : paragraphs(verb.footer)) text += paragraph_text(paragraph);
  return text;
}

// 64 with the names of its failures, and so on.
std::string exit_statuses() {
  std::map<int, std::string> names;
  for (const ErrorCodeInfo& info : all_error_codes()) {
    std::string& list = names[exit_status(info.code)];
    list += (list.empty() ? "" : ", ") + ("SL" + std::to_string(static_cast<int>(info.code)) + " " +
                                          std::string(info.name));
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
  return text + ".PP\n\\fBsightline diff\\fR alone exits 0 where maps are the same, 1 where they "
                "differ, 2 in trouble.\n";
}

}  // namespace

std::string man_page(const CommandTree& tree, const std::string& version) {
  std::string text = ".TH SIGHTLINE 1 \"\" \"sightline " + version + "\" \"User Commands\"\n.ad l\n";
  text += ".SH NAME\n" + roff(tree.name) +
          " \\- compile recorded drives into a map that tells a vehicle how far it must look\n";
  text += ".SH SYNOPSIS\n";
  for (const CommandVerb& verb : tree.verbs) text += usage(tree, verb) + "\n.br\n";
  text += ".SH DESCRIPTION\n" + roff(tree.summary.substr(0, tree.summary.find('\n'))) + "\n";
  text +=
      ".PP\nData goes to stdout, log and progress to stderr. Outputs appear whole or not at all and "
      "are not overwritten without \\fB\\-\\-force\\fR. Finished passes are cached beside the "
      "configuration.\n";
  text += ".SH COMMANDS\n";
  for (const CommandVerb& verb : tree.verbs) text += verb_text(tree, verb);
  text += ".SH EXIT STATUS\n" + exit_statuses();
  text +=
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
