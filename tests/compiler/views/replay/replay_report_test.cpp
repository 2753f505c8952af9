#include "compiler/views/replay/replay_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "formats/base/files/atomic_file.h"
#include "tests/compiler/views/replay/small_replay.h"
#include "tests/support/json_schema.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

using Json = nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

ReplayReport small_report() {
  const SmallReplay small = small_replay();
  return {"monday", {{"town.slmap", 7, {}}}, figures_of(small.scans, small.drive), {}};
}

Json localize_schema() {
  return Json::parse(
      *read_text_file(std::string(SIGHTLINE_ROOT) + "/schemas/localize.schema.json"));
}

ComparedPoses small_comparison() {
  ComparedPoses compared{"truth.txt", {}, {}};
  compared.errors.pair_count = 7;
  compared.errors.absolute_m = compared.errors.absolute_deg = {7, 0.2, 0.1, 0.05, 0.01, 0.0, 0.4};
  compared.errors.relative_m = {6, 0.02, 0.01, 0.005, 0.001, 0.0, 0.123456789};
  return compared;
}

TEST(ReplayReport, CountsScansTimesAndStretches) {
  const ReplayFigures figures = small_report().figures;
  EXPECT_EQ(figures.scan_count, 10U);
  EXPECT_EQ(figures.localized_count, 7U);
  EXPECT_EQ(figures.doubtful_count, 1U);
  EXPECT_EQ(figures.lost_scan_count, 2U);
  EXPECT_EQ(figures.skipped_count, 1U);
  EXPECT_DOUBLE_EQ(figures.period_ms, 100.0);
  EXPECT_DOUBLE_EQ(figures.duration_s, 0.9);
  EXPECT_DOUBLE_EQ(figures.median_ms, 5.0) << "1 to 10 ms without the sixth";
  ASSERT_EQ(figures.stretches.size(), 2U);
  EXPECT_FALSE(figures.stretches[0].is_lost);
  EXPECT_EQ(figures.stretches[1].first, 7U);
  EXPECT_EQ(figures.stretches[1].last, 8U);
  EXPECT_EQ(figures.stretches[1].last_world_m.x(), 1008.0);
}

TEST(ReplayReport, IsFourLines) {
  const std::string text = to_text(small_report());
  EXPECT_EQ(std::ranges::count(text, '\n'), 4);
  EXPECT_THAT(text, StartsWith("Localized  7 of 10 scans (70.0 %) of monday, 0.9 s\n"));
  EXPECT_THAT(text, HasSubstr("Lost       2 scans (20.0 %), 1 time after it was localized; 1 "
                              "scan could not be read\n"));
  EXPECT_THAT(text, HasSubstr("Time       5.00 ms per scan (median), 9.92 ms (p99): 5.0 % and 9.9 "
                              "% of the 100 ms between scans\n"));
  EXPECT_THAT(text, HasSubstr("In doubt   1 scan (10.0 %), 1 of these after the plan's second "
                              "look: lost at scans 7 to 8 (1007.0, -2.0, "
                              "0.5) to (1008.0, -2.0, 0.5); scan 2 (1002.0, -2.0, 0.5)\n"));
}

TEST(ReplayReport, HasALineOfSeveralMaps) {
  ReplayReport report = small_report();
  report.maps = {{"west.slmap", 1, {}},
                 {"east.slmap", 6, {}},
                 {"gone.slmap", 0, Error{ErrorCode::kFileNotFound, "cannot open", "gone.slmap"}}};
  EXPECT_THAT(to_text(report), HasSubstr("\nMaps       west.slmap 1 scan; east.slmap 6 scans; "
                                         "gone.slmap cannot be read\n"));
  const Json json = Json::parse(to_json(report));
  EXPECT_EQ(schema_faults(localize_schema(), json), "");
  EXPECT_EQ(json["map"], "west.slmap");
  EXPECT_EQ(json["maps"][1]["localized"], 6);
  EXPECT_EQ(json["maps"][2]["fault"], "SL2001 file-not-found: gone.slmap: cannot open");
}

TEST(ReplayReport, HasNoPlaceOfScansBeforeTheVehicleWasFound) {
  SmallReplay small = small_replay();
  for (std::size_t i : {std::size_t{0}, std::size_t{1}}) {
    ReplayedScan& scan = small.drive.scans[i] = ReplayedScan();
    scan.state = ScanState::kLost;
    scan.has_pose = false;
  }
  const ReplayReport report{
      "monday", {{"town.slmap", 7, {}}}, figures_of(small.scans, small.drive), {}};
  EXPECT_THAT(to_text(report), HasSubstr("not found: scans 0 to 1; "));
  EXPECT_THAT(to_text(report), Not(HasSubstr("(0.0, 0.0, 0.0)")));
  const Json json = Json::parse(to_json(report));
  EXPECT_TRUE(json["stretches"][0]["first_world_m"].is_null());
  EXPECT_EQ(schema_faults(localize_schema(), json), "");
}

TEST(ReplayReport, NamesTheLongestStretchesAndCountsTheRest) {
  ReplayReport report = small_report();
  const DoubtfulStretch stretch = report.figures.stretches.front();
  report.figures.stretches.assign(8, stretch);
  EXPECT_THAT(to_text(report), HasSubstr("; and 3 more\n"));
}

TEST(ReplayReport, HasATableOfErrorsWhereItCompares) {
  ReplayReport report = small_report();
  report.compared = small_comparison();
  const std::string text = to_text(report);
  EXPECT_THAT(text, HasSubstr("\n7 poses compared with truth.txt, not aligned\n"));
  EXPECT_THAT(text, HasSubstr("relative, over 1 frame, m"));
  EXPECT_THAT(text, HasSubstr("0.123457"));
}

TEST(ReplayReport, InJsonKeepsToItsSchema) {
  const Json schema = localize_schema();
  ReplayReport report = small_report();
  const Json plain = Json::parse(to_json(report));
  EXPECT_EQ(schema_faults(schema, plain), "");
  EXPECT_TRUE(plain["compared"].is_null());
  EXPECT_EQ(plain["stretches"][1]["state"], "lost");
  EXPECT_EQ(plain["stretches"][1]["first_world_m"], Json({1007.0, -2.0, 0.5}));
  report.compared = small_comparison();
  Json compared = Json::parse(to_json(report));
  EXPECT_EQ(schema_faults(schema, compared), "");
  EXPECT_EQ(compared["compared"]["absolute_m"]["max"], 0.4);
  EXPECT_TRUE(compared["compared"]["relative_deg"].is_null()) << "no step was long enough";
  compared["stretches"][0]["state"] = "unsure";
  EXPECT_NE(schema_faults(schema, compared), "");
}

}  // namespace
}  // namespace sightline
