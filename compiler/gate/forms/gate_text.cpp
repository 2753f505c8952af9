#include "compiler/gate/forms/gate_text.h"

#include <algorithm>
#include <array>

namespace sightline {
namespace {

std::string map_line(const std::string& what, const GateMapCard& card) {
  return what + card.file + " (map " + card.map_id + ", version " + card.version + ", release " +
         std::to_string(card.release) + ")\n";
}

template <class Wanted>
std::string lines_of(const GateReport& report, const Wanted& wanted) {
  std::string text;
  for (const Check& check : report.checks) {
    if (!wanted(check)) continue;
    text += "  [" + check.rule + "] " + check.message;
    if (!check.exception.empty()) text += "\n    excepted: " + check.exception;
    text += "\n";
  }
  return text;
}

std::string section(const std::string& title, const std::string& lines) {
  return lines.empty() ? "" : title + "\n" + lines;
}

}  // namespace

std::string to_text(const GateReport& report) {
  std::string text = map_line("gate of ", report.map);
  if (report.old_map) text += map_line("against ", *report.old_map);
  static constexpr std::array<const char*, 3> kTitles = {"notes", "warnings", "errors"};
  for (const Severity severity : {Severity::kError, Severity::kWarning, Severity::kNote}) {
    text += section(kTitles[static_cast<std::size_t>(severity)],
                    lines_of(report, [&](const Check& check) {
                      return check.verdict == Verdict::kViolated && check.severity == severity;
                    }));
  }
  for (const Verdict verdict : {Verdict::kExcepted, Verdict::kNotJudged, Verdict::kMet}) {
    text += section(std::string(verdict_name(verdict)),
                    lines_of(report, [&](const Check& check) { return check.verdict == verdict; }));
  }
  text += report.passes() ? "passed: " : "failed: ";
  return text + std::to_string(report.violations(Severity::kError)) + " errors, " +
         std::to_string(report.violations(Severity::kWarning)) + " warnings, " +
         std::to_string(report.violations(Severity::kNote)) + " notes; " +
         std::to_string(report.count(Verdict::kExcepted)) + " excepted, " +
         std::to_string(report.count(Verdict::kMet)) + " met, " +
         std::to_string(report.count(Verdict::kNotJudged)) + " not judged\n";
}

}  // namespace sightline
