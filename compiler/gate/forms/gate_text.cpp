#include "compiler/gate/forms/gate_text.h"

#include <algorithm>
#include <array>

#include "compiler/gate/rules/rules.h"
#include "compiler/views/verdict/verdict_text.h"
#include "formats/base/printable.h"
#include "formats/text/quoted_text.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

std::string map_line(const std::string& what, const GateMapCard& card) {
  return concat(what, one_line(card.file), " (map ", one_line(card.map_id), ", version ",
                one_line(card.version), ", release ", card.release, ")\n");
}

template <class Wanted>
std::string lines_of(const GateReport& report, const Wanted& wanted) {
  std::string text;
  for (const Check& check : report.checks) {
    if (!wanted(check)) continue;
    text += "  " + wrapped(concat("[", check.rule, "] ", check.message), 118, 4);
    if (!check.exception.empty()) text += "    excepted: " + check.exception + "\n";
  }
  return text;
}

std::string section(const std::string& title, const std::string& lines) {
  return lines.empty() ? "" : concat(title, "\n", lines);
}

// ", 14 checks met, 2 errors, 1 not judged": without what there is none of.
std::string gate_counts(const GateReport& report) {
  struct Counted {
    std::size_t count;
    const char* one;
    const char* many;
  };
  const Counted all[] = {{report.violations(Severity::kError), " error", " errors"},
                         {report.violations(Severity::kWarning), " warning", " warnings"},
                         {report.violations(Severity::kNote), " note", " notes"},
                         {report.count(Verdict::kExcepted), " excepted", " excepted"},
                         {report.count(Verdict::kNotJudged), " not judged", " not judged"}};
  std::string text = concat(", ", report.count(Verdict::kMet), " checks met");
  for (const Counted& each : all) {
    if (each.count > 0) text += concat(", ", each.count, each.count == 1 ? each.one : each.many);
  }
  return text;
}

std::string place_of(const Check& check) {
  if (!check.place) return "map";
  const RouteStretch& place = *check.place;
  return concat(place.is_of_old ? "old " : "", "sites ", place.first_site, " to ", place.last_site);
}

// ", allowed at most 5.0 m"
std::string allowed_words(const Check& check) {
  const auto rule = std::ranges::find(gate_rules(), check.rule, &GateRule::id);
  const bool is_most = rule == gate_rules().end() || rule->bound == Bound::kAtMost;
  return concat(", allowed ", is_most ? "at most " : "at least ",
                in_words(*check.allowed, check.unit));
}

// A line for each violation, errors first: "  error worst-stretch within 0.1 m, sites 3 to 9: ...".
std::vector<std::string> violation_lines(const GateReport& report) {
  std::vector<std::string> lines;
  for (const Severity severity : {Severity::kError, Severity::kWarning, Severity::kNote}) {
    for (const Check& check : report.checks) {
      if (check.verdict != Verdict::kViolated || check.severity != severity) continue;
      std::string line = concat("  ", severity_name(severity), " ", check.rule);
      if (check.limit_m) line += within(*check.limit_m);
      if (check.place) line += ", " + place_of(check);
      line += ": " + in_words(check.found, check.unit);
      if (check.allowed) line += allowed_words(check);
      lines.push_back(line + "\n");
    }
  }
  return lines;
}

std::string row(const Check& check) {
  const std::string limit = check.limit_m ? format_double(*check.limit_m) + " m" : "";
  const std::string allowed = check.allowed ? in_words(*check.allowed, check.unit) : "";
  return concat("| ", severity_name(check.severity), " | `", check.rule, "` | ", limit, " | ",
                place_of(check), " | ", in_words(check.found, check.unit), " | ", allowed, " | ",
                markdown_text(check.message),
                (check.exception.empty() ? "" : "; excepted: " + markdown_text(check.exception)),
                " |\n");
}

std::string table(const std::string& rows) {
  return "| severity | rule | limit | place | found | allowed | what |\n"
         "|---|---|---|---|---|---|---|\n" +
         rows;
}

std::string folded(const std::string& title, const std::string& rows) {
  if (rows.empty()) return "";
  return concat("\n<details><summary>", title, "</summary>\n\n", table(rows), "\n</details>\n");
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

std::string name_of(const Check& check) {
  return check.limit_m ? concat(check.rule, " within ", format_double(*check.limit_m), " m")
                       : check.rule;
}

// Checks of one rule and limit.
struct Case {
  std::string name;
  std::vector<const Check*> checks;

  [[nodiscard]] bool fails(Severity fails_at) const {
    return std::ranges::any_of(checks, [&](const Check* check) {
      return check->verdict == Verdict::kViolated && check->severity >= fails_at;
    });
  }
  // Nothing was judged, or all that was found is excepted.
  [[nodiscard]] bool is_skipped() const {
    return std::ranges::none_of(checks, [](const Check* check) {
      return check->verdict == Verdict::kMet || check->verdict == Verdict::kViolated;
    });
  }
};

std::vector<Case> cases_of(const GateReport& report) {
  std::vector<Case> cases;
  for (const Check& check : report.checks) {
    const auto known = std::ranges::find(cases, name_of(check), &Case::name);
    Case& into = known == cases.end() ? cases.emplace_back(Case{name_of(check), {}}) : *known;
    into.checks.push_back(&check);
  }
  return cases;
}

std::string to_xml(const Case& test, Severity fails_at) {
  const std::string head = concat("    <testcase classname=\"sightline.gate\" name=\"",
                                  xml_text(test.name), "\" time=\"0\"");
  if (!test.fails(fails_at)) {
    return head + (test.is_skipped() ? "><skipped/></testcase>\n" : "/>\n");
  }
  std::string first;
  std::string all;
  for (const Check* check : test.checks) {
    if (check->verdict != Verdict::kViolated) continue;
    if (first.empty()) first = check->message;
    all += check->message + "\n";
  }
  return concat(head, "><failure type=\"", xml_text(test.checks.front()->rule), "\" message=\"",
                xml_text(first), "\">", xml_text(all), "</failure></testcase>\n");
}

std::string property(const std::string& name, const std::string& value) {
  return concat("      <property name=\"", name, "\" value=\"", xml_text(value), "\"/>\n");
}

std::string properties_of(const GateReport& report) {
  std::string xml = property("map", report.map.file) + property("map_id", report.map.map_id) +
                    property("root_digest", report.map.root_digest) +
                    property("verdict", std::string(word_of(report.verdict.verdict)));
  if (!report.old_map) return xml;
  return xml + property("old_map", report.old_map->file) +
         property("old_root_digest", report.old_map->root_digest);
}

// What JUnit has no element for: what was found and does not fail the gate.
std::string warnings_of(const GateReport& report) {
  std::string text;
  for (const Check& check : report.checks) {
    const bool is_failure =
        check.verdict == Verdict::kViolated && check.severity >= report.fails_at;
    if (check.verdict == Verdict::kMet || is_failure) continue;
    text += concat(check.verdict == Verdict::kViolated ? severity_name(check.severity)
                                                       : verdict_name(check.verdict),
                   " [", check.rule, "] ", check.message);
    if (!check.exception.empty()) text += "; excepted: " + check.exception;
    text += "\n";
  }
  return text;
}

}  // namespace

std::string to_text(const GateReport& report) {
  std::string text = to_text(report.verdict) + map_line("gate of ", report.map);
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
  return text + gate_head(report) + gate_counts(report) + "\n";
}

std::string gate_head(const GateReport& report) {
  return report.passes() ? "Gate: passed" : "Gate: failed";
}

std::string to_summary(const GateReport& report) {
  constexpr std::size_t kMostLines = 12;
  const std::string verdict = to_text(report.verdict);
  const auto taken = static_cast<std::size_t>(std::ranges::count(verdict, '\n')) + 1;
  const std::vector<std::string> lines = violation_lines(report);
  const std::size_t room = taken < kMostLines ? kMostLines - taken : 1;
  const std::size_t shown = lines.size() <= room ? lines.size() : room - 1;
  std::string text = verdict + gate_head(report) + gate_counts(report) + "\n";
  for (std::size_t i = 0; i < shown; ++i) text += lines[i];
  if (shown == lines.size()) return text;
  return concat(text, "  and ", lines.size() - shown, " more: --all prints every check\n");
}

std::string to_markdown(const GateReport& report) {
  std::string text =
      concat("### sightline gate: ", (report.passes() ? "passed" : "failed"), "\n\n`",
             markdown_code(report.map.file), "` (version ", markdown_text(report.map.version),
             ", release ", report.map.release, ")");
  if (report.old_map) text += concat(" against `", markdown_code(report.old_map->file), "`");
  text += concat(": ", report.violations(Severity::kError), " errors, ",
                 report.violations(Severity::kWarning), " warnings, ",
                 report.violations(Severity::kNote), " notes.\n\n", to_markdown(report.verdict));
  const std::string violated = rows_of(report, Verdict::kViolated);
  if (!violated.empty()) text += "\n" + table(violated);
  return text + folded("Excepted", rows_of(report, Verdict::kExcepted)) +
         folded("Not judged", rows_of(report, Verdict::kNotJudged)) +
         folded("Met", rows_of(report, Verdict::kMet));
}

std::string to_github(const GateReport& report) {
  static constexpr std::array<const char*, 3> kCommands = {"notice", "warning", "error"};
  std::string text;
  for (const Check& check : report.checks) {
    if (check.verdict != Verdict::kViolated) continue;
    const bool is_of_old = check.place && check.place->is_of_old && report.old_map;
    text +=
        concat("::", kCommands[static_cast<std::size_t>(check.severity)],
               " file=", github_property(is_of_old ? report.old_map->file : report.map.file),
               ",title=", github_property(check.rule), "::", github_message(check.message), "\n");
  }
  const char* verdict = report.passes() ? "::notice title=sightline gate::passed"
                                        : "::error title=sightline gate::failed";
  return concat(text, verdict, ", ", report.violations(Severity::kError), " errors and ",
                report.violations(Severity::kWarning),
                " warnings; map verdict: ", word_of(report.verdict.verdict), "\n");
}

std::string to_junit(const GateReport& report) {
  const std::vector<Case> cases = cases_of(report);
  const std::string failures = std::to_string(
      std::ranges::count_if(cases, [&](const Case& test) { return test.fails(report.fails_at); }));
  const std::string skipped = std::to_string(std::ranges::count_if(cases, &Case::is_skipped));
  std::string xml = concat(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n"
      "  <testsuite id=\"0\" package=\"sightline\" name=\"gate\" hostname=\"localhost\" time=\"0\" "
      "timestamp=\"",
      report.today, "T00:00:00\" tests=\"", cases.size(), "\" failures=\"", failures,
      "\" errors=\"0\" skipped=\"", skipped, "\">\n    <properties>\n", properties_of(report),
      "    </properties>\n");
  for (const Case& test : cases) xml += to_xml(test, report.fails_at);
  return concat(xml, "    <system-out>", xml_text(warnings_of(report)),
                "</system-out>\n    <system-err></system-err>\n  </testsuite>\n</testsuites>\n");
}

}  // namespace sightline
