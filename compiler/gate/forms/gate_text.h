#pragma once

#include <string>

#include "compiler/gate/rules/rules.h"

// A report of the gate in the forms that people and CI systems read. All end in a newline.

namespace sightline {

// "Gate: passed" or "Gate: failed", without its end: what is coloured at a terminal.
std::string gate_head(const GateReport& report);

// For people at a terminal, at most 12 lines: the verdict on the map, the result of the gate, and a
// line for each violation as far as there is room.
std::string to_summary(const GateReport& report);

// The verdict, and every check: violations first, then what could not be judged, then one line a
// check that was met.
std::string to_text(const GateReport& report);

// Every check with its numbers: schemas/gate.schema.json.
std::string to_json(const GateReport& report);

// One test case for each rule and limit. Errors are failures; warnings and notes pass and are
// listed in system-out; what was excepted or not judged is skipped. Times are 0 and the time stamp
// is the day of the report: the same report gives the same bytes.
std::string to_junit(const GateReport& report);

// SARIF 2.1.0. A stretch of route is a logical location; the physical one is the map file. Excepted
// findings are suppressed results with the exception's reason. Fingerprints hold rule, limit and
// place to 50 m, so that a finding is recognised in the next run.
std::string to_sarif(const GateReport& report);

// Workflow commands of GitHub Actions, one line a violation: ::error title=..,file=..::message
std::string to_github(const GateReport& report);

// For a step summary or a comment: verdict, a table of violations, and the rest folded away.
std::string to_markdown(const GateReport& report);

}  // namespace sightline
