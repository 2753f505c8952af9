#include "compiler/views/report/page/report_sources.h"

#include <gtest/gtest.h>

#include "compiler/gate/forms/gate_text.h"
#include "formats/base/files/atomic_file.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

GateReport made_report() {
  GateReport report;
  report.map.root_digest = "ab12";
  Check met;
  met.rule = "plane-thickness";
  Check violated;
  violated.rule = "unmet-share";
  violated.verdict = Verdict::kViolated;
  violated.message = "too many";
  violated.place = RouteStretch{};
  violated.place->first_site = 40;
  Check of_old = violated;
  of_old.severity = Severity::kWarning;
  of_old.place->is_of_old = true;
  report.checks = {met, violated, of_old};
  return report;
}

Result<GateResult> read_back(const std::string& text) {
  std::filesystem::create_directories(scratch_folder());
  const std::filesystem::path file = scratch_folder() / "gate.json";
  EXPECT_TRUE(write_file_atomically(file, text, IfExists::kReplace).has_value());
  return read_gate_result(file);
}

TEST(GateResult, IsWhatTheGateWrote) {
  const GateResult result = value_of(read_back(to_json(made_report())));
  EXPECT_EQ(result.root_digest, "ab12");
  EXPECT_FALSE(result.passed);
  EXPECT_EQ(result.errors, 1U);
  EXPECT_EQ(result.warnings, 1U);
  ASSERT_EQ(result.violations.size(), 2U);
  EXPECT_EQ(result.violations[0].rule, "unmet-share");
  EXPECT_EQ(result.violations[0].message, "too many");
  EXPECT_EQ(result.violations[0].first_site, 40U);
  EXPECT_EQ(result.violations[1].first_site, std::nullopt);
}

TEST(GateResult, RefusesOtherFiles) {
  const std::string whole = to_json(made_report());
  for (const std::string& text : {std::string(), std::string("[]"), whole.substr(0, 200)}) {
    EXPECT_EQ(code_of(read_back(text)), ErrorCode::kMalformedText);
  }
}

}  // namespace
}  // namespace sightline
