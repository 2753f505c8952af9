#include <algorithm>

#include "compiler/gate/forms/gate_text.h"
#include "formats/text/quoted_text.h"
#include "formats/text/table.h"

namespace sightline {
namespace {

std::string name_of(const Check& check) {
  return check.limit_m ? check.rule + " within " + format_double(*check.limit_m) + " m"
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
  const std::string head =
      "    <testcase classname=\"sightline.gate\" name=\"" + xml_text(test.name) + "\" time=\"0\"";
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
  return head + "><failure type=\"" + xml_text(test.checks.front()->rule) + "\" message=\"" +
         xml_text(first) + "\">" + xml_text(all) + "</failure></testcase>\n";
}

std::string property(const std::string& name, const std::string& value) {
  return "      <property name=\"" + name + "\" value=\"" + xml_text(value) + "\"/>\n";
}

std::string properties_of(const GateReport& report) {
  std::string xml = property("map", report.map.file) + property("map_id", report.map.map_id) +
                    property("root_digest", report.map.root_digest);
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
    text += std::string(check.verdict == Verdict::kViolated ? severity_name(check.severity)
                                                            : verdict_name(check.verdict));
    text += " [" + check.rule + "] " + check.message;
    if (!check.exception.empty()) text += "; excepted: " + check.exception;
    text += "\n";
  }
  return text;
}

}  // namespace

std::string to_junit(const GateReport& report) {
  const std::vector<Case> cases = cases_of(report);
  const std::string failures = std::to_string(
      std::ranges::count_if(cases, [&](const Case& test) { return test.fails(report.fails_at); }));
  const std::string skipped = std::to_string(std::ranges::count_if(cases, &Case::is_skipped));
  std::string xml =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n"
      "  <testsuite id=\"0\" package=\"sightline\" name=\"gate\" hostname=\"localhost\" time=\"0\" "
      "timestamp=\"" +
      report.today + "T00:00:00\" tests=\"" + std::to_string(cases.size()) + "\" failures=\"" +
      failures + "\" errors=\"0\" skipped=\"" + skipped + "\">\n    <properties>\n" +
      properties_of(report) + "    </properties>\n";
  for (const Case& test : cases) xml += to_xml(test, report.fails_at);
  return xml + "    <system-out>" + xml_text(warnings_of(report)) +
         "</system-out>\n    <system-err></system-err>\n  </testsuite>\n</testsuites>\n";
}

}  // namespace sightline
