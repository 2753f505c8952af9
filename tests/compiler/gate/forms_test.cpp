#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "compiler/gate/forms/gate_text.h"
#include "formats/base/files/atomic_file.h"
#include "tests/compiler/gate/gate_on_map.h"
#include "tests/compiler/gate/route_map.h"
#include "tests/support/json_schema.h"
#include "tests/support/scratch_folder.h"

namespace sightline {
namespace {

using testing::HasSubstr;
using Json = nlohmann::json;
const std::filesystem::path kRoot = SIGHTLINE_ROOT;

// Two errors of a stretch (one a limit), a warning, an exception and things not judged; names that
// XML, URIs and Markdown must escape.
GateReport full_report() {
  const CompiledMap before = route_map(120);
  CompiledMap after = before;
  for (std::size_t site = 60; site < 90; ++site) set_site(after, site, {2, 0.05, 0.95, 0});
  sum_up(after);
  after.sensor.name = "a <b> & \"c\" | d";
  after.version = "1|2";
  const Result<GateSettings> settings = parse_gate_settings(
      "exceptions: [{rule: work-rise, reason: 'new <GPU> & more', until: 2026-12-31}]");
  return judged(after, &before, *settings);
}

Json schema_of(const char* file) { return Json::parse(*read_text_file(kRoot / file)); }

TEST(GateForms, JsonIsAsItsSchemaSaysAndHoldsEveryNumber) {
  const GateReport report = full_report();
  const Json json = Json::parse(to_json(report));
  EXPECT_EQ(schema_faults(schema_of("schemas/gate.schema.json"), json), "");
  ASSERT_EQ(json["checks"].size(), report.checks.size());
  EXPECT_EQ(json["errors"], report.violations(Severity::kError));
  const auto rise = std::ranges::find_if(json["checks"], [](const Json& check) {
    return check["rule"] == "stretch-range-rise" && check["limit_m"] == 0.1;
  });
  ASSERT_NE(rise, json["checks"].end());
  EXPECT_EQ((*rise)["found"], 40.0);
  EXPECT_EQ((*rise)["allowed"], 5.0);
  EXPECT_EQ((*rise)["place"]["first_site"], 60);
  EXPECT_EQ((*rise)["place"]["middle_world_m"], Json::array({714.0, -64.0, 1.8}));
  Json bad = json;
  bad["checks"][0]["verdict"] = "maybe";
  EXPECT_NE(schema_faults(schema_of("schemas/gate.schema.json"), bad), "");
}

TEST(GateForms, SarifIsValidAndSuppressesWhatIsExcepted) {
  const Json schema = schema_of("tests/compiler/gate/schemas/sarif-2.1.0-rtm.5.json");
  const GateReport report = full_report();
  const Json json = Json::parse(to_sarif(report));
  EXPECT_EQ(schema_faults(schema, json), "");
  Json bad = json;
  bad["runs"][0]["results"][0]["level"] = "fatal";
  EXPECT_NE(schema_faults(schema, bad), "") << "the schema must be able to refuse";
  std::size_t suppressed = 0;
  std::size_t open = 0;
  for (const Json& result : json["runs"][0]["results"]) {
    (result.contains("suppressions") ? suppressed : open) += 1;
    const std::size_t index = result["ruleIndex"];
    EXPECT_EQ(json["runs"][0]["tool"]["driver"]["rules"][index]["id"], result["ruleId"]);
    EXPECT_EQ(result["locations"][0]["physicalLocation"]["artifactLocation"]["uri"],
              "maps/new%20town.slmap");
  }
  const Json& driver = json["runs"][0]["tool"]["driver"];
  EXPECT_TRUE(std::regex_match(driver["semanticVersion"].get<std::string>(),
                               std::regex("\\d+\\.\\d+\\.\\d+.*")));
  for (const Json& rule : driver["rules"]) {
    EXPECT_THAT(rule["help"]["text"].get<std::string>(), HasSubstr("sightline inspect"));
    EXPECT_THAT(rule["help"]["markdown"].get<std::string>(),
                HasSubstr(rule["id"].get<std::string>() + ": {allowed: ...}"));
  }
  EXPECT_EQ(suppressed, report.count(Verdict::kExcepted));
  EXPECT_EQ(open, report.count(Verdict::kViolated));
}

TEST(GateForms, SarifPointsAtTheRulesWhereTheyStandInAFile) {
  GateReport report = full_report();
  report.rules_file = "maps/drive.yaml";
  report.rules_line = 12;
  const Json json = Json::parse(to_sarif(report));
  EXPECT_EQ(schema_faults(schema_of("tests/compiler/gate/schemas/sarif-2.1.0-rtm.5.json"), json),
            "");
  for (const Json& result : json["runs"][0]["results"]) {
    const Json& location = result["locations"][0];
    EXPECT_EQ(location["physicalLocation"]["artifactLocation"]["uri"], "maps/drive.yaml");
    EXPECT_EQ(location["physicalLocation"]["region"]["startLine"], 12);
    EXPECT_EQ(location["message"]["text"], "of the map maps/new town.slmap");
  }
}

// The schema is Apache Ant's; xmllint is libxml2's.
TEST(GateForms, JunitIsValidAndFailsTheSameRules) {
  const std::string xml = to_junit(full_report());
  const std::filesystem::path file = scratch_folder() / "gate.xml";
  ASSERT_TRUE(write_file_atomically(file, xml, IfExists::kReplace));
  const std::string schema = (kRoot / "tests/compiler/gate/schemas/JUnit.xsd").string();
  const std::string check = "xmllint --noout --nonet --schema '" + schema + "' '" + file.string() +
                            "' > '" + file.string() + ".log' 2>&1";
  if (std::system("command -v xmllint > /dev/null") != 0) GTEST_SKIP() << "there is no xmllint";
  EXPECT_EQ(std::system(check.c_str()), 0) << *read_text_file(file.string() + ".log");
  ASSERT_TRUE(
      write_file_atomically(file, "<testsuites><testsuite/></testsuites>", IfExists::kReplace));
  EXPECT_NE(std::system(check.c_str()), 0) << "the schema must be able to refuse";
  EXPECT_THAT(xml, HasSubstr("name=\"stretch-range-rise within 0.1 m\" time=\"0\"><failure"));
  EXPECT_THAT(xml, HasSubstr("name=\"work-rise within 0.1 m\" time=\"0\"><skipped/>"));
  EXPECT_THAT(xml, HasSubstr("a &lt;b&gt; &amp; &quot;c&quot; | d"));
}

TEST(GateForms, JunitFailsWhatTheGateFailsAt) {
  GateReport report = full_report();
  EXPECT_THAT(to_junit(report), HasSubstr("name=\"sensor-change\" time=\"0\"/>"));
  report.fails_at = Severity::kWarning;
  EXPECT_THAT(to_junit(report), HasSubstr("name=\"sensor-change\" time=\"0\"><failure"));
}

TEST(GateForms, GithubAnnotationsAreOneLineEachAndEscaped) {
  const GateReport report = full_report();
  const std::string text = to_github(report);
  EXPECT_THAT(text,
              HasSubstr("::error file=maps/new town.slmap,title=stretch-range-rise::sites 60 "
                        "to 89 (run 0, 60 to 89 m, around (714.0, -64.0, 1.8) m in the world): "
                        "the range within 0.1 m was 10.0 m and is 50.0 m over the worst 20 m "
                        "of route, 40.0 m more; allowed is at most 5.0 m\n"));
  EXPECT_EQ(static_cast<std::size_t>(std::ranges::count(text, '\n')),
            report.count(Verdict::kViolated) + 1);
  EXPECT_THAT(text, HasSubstr("::error title=sightline gate::failed, "));
  GateReport odd = report;
  odd.map.file = "a,b:c%d.slmap";
  EXPECT_THAT(to_github(odd), HasSubstr("file=a%2Cb%3Ac%25d.slmap,title="));
}

TEST(GateForms, MarkdownHasARowForEveryCheck) {
  const GateReport report = full_report();
  const std::string text = to_markdown(report);
  EXPECT_THAT(text, HasSubstr("### sightline gate: failed\n"));
  EXPECT_THAT(text, HasSubstr("| error | `stretch-range-rise` | 0.1 m | sites 60 to 89 | 40.0 m | "
                              "5.0 m | sites 60 to 89 (run 0, 60 to 89 m, around "));
  EXPECT_THAT(text, HasSubstr("a &lt;b> & \"c\" \\| d"));
  std::size_t rows = 0;
  for (std::size_t at = text.find("| `"); at != std::string::npos; at = text.find("| `", at + 1)) {
    ++rows;
  }
  EXPECT_EQ(rows, report.checks.size());
}

TEST(GateForms, TextTellsErrorsFirstWithTheirPlace) {
  const std::string text = to_text(full_report());
  EXPECT_LT(text.find("\nerrors\n"), text.find("\nwarnings\n"));
  EXPECT_THAT(text, HasSubstr("around (714.0, -64.0, 1.8) m in the world"));
  EXPECT_THAT(text, HasSubstr("excepted: new <GPU> & more (until 2026-12-31)"));
  EXPECT_THAT(text, HasSubstr("\nGate: failed, "));
}

TEST(GateForms, SummaryFitsOnTwelveLinesAndCountsWhatItLeavesOut) {
  const CompiledMap before = route_map(2000);
  CompiledMap after = before;
  for (std::size_t site = 0; site < 2000; ++site) {
    if (site / 50 % 2 == 0) set_site(after, site, {2, 0.05, 0.95, 0});
  }
  sum_up(after);
  const GateReport report = judged(after, &before);
  ASSERT_GT(report.count(Verdict::kViolated), 12U);
  const std::string text = to_summary(report);
  EXPECT_EQ(std::ranges::count(text, '\n'), 12);
  EXPECT_TRUE(text.starts_with("Verdict: "));
  EXPECT_THAT(text, HasSubstr("\nGate: failed, "));
  EXPECT_THAT(text, HasSubstr("  error stretch-range-rise within 0.1 m, sites "));
  EXPECT_THAT(text, HasSubstr(" more: --all prints every check\n"));
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 120U) << line;
}

TEST(GateForms, SummaryHasEveryViolationWhereThereIsRoom) {
  const GateReport report = judged(route_map(120));
  const std::string text = to_summary(report);
  EXPECT_THAT(text, HasSubstr("\nGate: passed, "));
  EXPECT_EQ(text.find("--all prints"), std::string::npos) << text;
}

TEST(GateRules, AreAsTheyAreDocumented) {
  const std::string documented = *read_text_file(kRoot / "schemas/gate_rules.md");
  EXPECT_NE(documented.find(rules_table()), std::string::npos) << rules_table();
  std::set<std::string_view> ids;
  for (const GateRule& rule : gate_rules()) EXPECT_TRUE(ids.insert(rule.id).second) << rule.id;
}

TEST(GateRules, AreInTheSchemaOfTheSettings) {
  const Json schema = Json::parse(gate_settings_schema());
  for (const GateRule& rule : gate_rules()) {
    EXPECT_EQ(schema_faults(schema, {{"rules", {{std::string(rule.id), "note"}}}}), "") << rule.id;
  }
  const Json settings = {
      {"rules", {{"mean-range", 30}, {"unmet-share", "off"}}},
      {"exceptions",
       {{{"rule", "*"}, {"reason", "r"}, {"until", "2026-01-01"}, {"circle", {1, 2, 3}}}}}};
  EXPECT_EQ(schema_faults(schema, settings), "");
  EXPECT_NE(schema_faults(schema, {{"rules", {{"mean-rang", 30}}}}), "");
}

}  // namespace
}  // namespace sightline
