#include "compiler/gate/forms/gate_text.h"
#include "compiler/gate/rules/rules.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

// Text in a cell of a table.
std::string cell(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '|') {
      safe += "\\|";
    } else if (c == '\n' || c == '\r') {
      safe += ' ';
    } else if (c == '<') {
      safe += "&lt;";
    } else {
      safe += c;
    }
  }
  return safe;
}

std::string place_of(const Check& check) {
  if (!check.place) return "map";
  const RouteStretch& place = *check.place;
  return std::string(place.is_of_old ? "old " : "") + "sites " + std::to_string(place.first_site) +
         " to " + std::to_string(place.last_site);
}

std::string row(const Check& check) {
  const std::string limit = check.limit_m ? format_double(*check.limit_m) + " m" : "";
  const std::string allowed = check.allowed ? in_words(*check.allowed, check.unit) : "";
  return "| " + std::string(severity_name(check.severity)) + " | `" + check.rule + "` | " + limit +
         " | " + place_of(check) + " | " + in_words(check.found, check.unit) + " | " + allowed +
         " | " + cell(check.message) +
         (check.exception.empty() ? "" : "; excepted: " + cell(check.exception)) + " |\n";
}

std::string table(const std::string& rows) {
  return "| severity | rule | limit | place | found | allowed | what |\n"
         "|---|---|---|---|---|---|---|\n" +
         rows;
}

std::string folded(const std::string& title, const std::string& rows) {
  if (rows.empty()) return "";
  return "\n<details><summary>" + title + "</summary>\n\n" + table(rows) + "\n</details>\n";
}

std::string rows_of(const GateReport& report, Verdict verdict) {
  std::string rows;
  for (const Severity severity : {Severity::kError, Severity::kWarning, Severity::kNote}) {
    for (const Check& check : report.checks) {
      if (check.verdict == verdict && check.severity == severity) rows += row(check);
    }
  }
  return rows;
}

}  // namespace

std::string to_markdown(const GateReport& report) {
  std::string text = std::string("### sightline gate: ") + (report.passes() ? "passed" : "failed") +
                     "\n\n`" + report.map.file + "` (version " + cell(report.map.version) +
                     ", release " + std::to_string(report.map.release) + ")";
  if (report.old_map) text += " against `" + report.old_map->file + "`";
  text += ": " + std::to_string(report.violations(Severity::kError)) + " errors, " +
          std::to_string(report.violations(Severity::kWarning)) + " warnings, " +
          std::to_string(report.violations(Severity::kNote)) + " notes.\n";
  const std::string violated = rows_of(report, Verdict::kViolated);
  if (!violated.empty()) text += "\n" + table(violated);
  return text + folded("Excepted", rows_of(report, Verdict::kExcepted)) +
         folded("Not judged", rows_of(report, Verdict::kNotJudged)) +
         folded("Met", rows_of(report, Verdict::kMet));
}

}  // namespace sightline
