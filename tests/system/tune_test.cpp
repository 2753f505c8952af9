#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "passes/localize/pcl/pcl_ndt.h"
#include "tests/support/json_schema.h"
#include "tests/system/program.h"

// `sightline tune` in a generated town.

namespace sightline {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using Json = nlohmann::json;

std::string tune(const std::string& options) {
  return "tune " + (small_town() / "town.yaml").string() + " --localizer pcl-ndt " + options;
}

Json tuned(const std::string& options) {
  return Json::parse(run_successfully(tune("--format json " + options)).out);
}

void forget_times(Json& json) {
  for (const char* row : {"defaults", "cheapest", "best"}) json[row].erase("time_ms");
  for (Json& row : json["tried"]) row.erase("time_ms");
}

class Tune : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!has_pcl_ndt()) GTEST_SKIP() << "built without PCL";
  }
};

TEST_F(Tune, PrintsAutowaresNumbersBesideWhatItFound) {
  const ProgramResult run = run_successfully(tune("--scans 4"));
  EXPECT_THAT(run.out, AllOf(HasSubstr("2 chose the numbers, 2 others judge them"),
                             HasSubstr("Autoware's numbers  60 m    3 m    1500"),
                             HasSubstr("least work"), HasSubstr("most within 10 cm")));
  EXPECT_THAT(run.err, HasSubstr("tune"));
}

TEST_F(Tune, IsJsonAndTheSameForAnyNumberOfThreads) {
  Json one = tuned("--scans 4 --limit 0.25 -j 1");
  const Json schema =
      Json::parse(bytes_of(std::string(SIGHTLINE_ROOT) + "/schemas/tune.schema.json"));
  EXPECT_EQ(schema_faults(schema, one), "");
  EXPECT_EQ(one["limit_m"], 0.25);
  EXPECT_EQ(one["tried"].size(), 75U);
  EXPECT_GT(one["defaults"]["time_ms"], 0.0);
  Json four = tuned("--scans 4 --limit 0.25 -j 4");
  forget_times(one);
  forget_times(four);
  EXPECT_EQ(one, four);
}

TEST_F(Tune, RefusesALimitThatIsNone) {
  const ProgramResult run = run_sightline(tune("--limit 0.2"));
  EXPECT_EQ(run.status, 64);
  EXPECT_THAT(run.err, HasSubstr("--limit: found 0.2, expected one of 0.1, 0.25"));
}

}  // namespace
}  // namespace sightline
