#include "compiler/views/replay/tuning_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "formats/base/files/atomic_file.h"
#include "tests/support/json_schema.h"

namespace sightline {
namespace {

using Json = nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

NdtTuning small_tuning() {
  NdtTuning tuning{"monday", 2.0, ErrorReference::kKnownPose, {0.1, 0.25}, 0, 5, 24, 23, {}, {},
                   {},       {}};
  tuning.defaults = {{}, {{0.9, 0.98}, 0.01, 0.05, 400.0, 2000.0, 8.0}};
  tuning.cheapest = {{30.0, 2.0, 500}, {{0.9, 0.97}, 0.0, 0.06, 250.0, 1000.0, 4.5}};
  tuning.best = {{60.0, 1.0, 3000}, {{0.95, 1.0}, 0.0, 0.03, 2500.0, 9000.0, 40.0}};
  tuning.tried = {tuning.defaults, tuning.cheapest, tuning.best};
  return tuning;
}

TEST(TuningReport, IsATableOfThreeRowsAndWhatToSet) {
  const std::string text = to_text(small_tuning());
  EXPECT_THAT(text, AllOf(HasSubstr("47 scans of monday: 24 chose the numbers, 23 others judge"),
                          HasSubstr("Autoware's numbers  60 m    3 m    1500"),
                          HasSubstr("within 10 cm  within 25 cm"), HasSubstr("4.5 ms")));
  EXPECT_THAT(
      text, HasSubstr("Cheaper, 50 % of the work: a box of 30 m, voxels of 2 m, 500 points; within "
                      "10 cm at 90.0 % of the matches instead of 90.0 %\n"
                      "  crop_box_filter_measurement_range: min_x, min_y -30, max_x, max_y 30\n"));
  EXPECT_THAT(text, AllOf(HasSubstr("random_downsample_filter: sample_num 500\n"),
                          HasSubstr("Better: a box of 60 m, voxels of 1 m, 3000 points; within 10 "
                                    "cm at 95.0 % of the matches instead of 90.0 %\n")));
}

TEST(TuningReport, SaysWhereNothingHelps) {
  NdtTuning tuning = small_tuning();
  tuning.cheapest = tuning.best = tuning.defaults;
  EXPECT_THAT(to_text(tuning), AllOf(HasSubstr("Nothing helps: none of 3 combinations"),
                                     Not(HasSubstr("Cheaper")), Not(HasSubstr("sample_num"))));
}

TEST(TuningReport, IsJsonOfItsSchema) {
  const Json schema =
      Json::parse(*read_text_file(std::string(SIGHTLINE_ROOT) + "/schemas/tune.schema.json"));
  const Json json = Json::parse(to_json(small_tuning()));
  EXPECT_EQ(schema_faults(schema, json), "");
  EXPECT_EQ(json["tried"].size(), 3U);
  EXPECT_EQ(json["cheapest"]["box_m"], 30.0);
  EXPECT_EQ(json["is_cheaper"], true);
  EXPECT_EQ(json["limit_m"], 0.1);
}

}  // namespace
}  // namespace sightline
