#include "formats/foreign/text/sensor_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/base/files/atomic_file.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

using ::testing::HasSubstr;

Result<SensorProfile> read(const std::string& name, const std::string& text) {
  const std::filesystem::path file = scratch_folder() / name;
  EXPECT_TRUE(write_file_atomically(file, text, IfExists::kReplace));
  EXPECT_TRUE(is_sensor_file(file.string()));
  return read_sensor_file(file);
}

TEST(SensorFile, OfYamlHoldsBeamsAndWhatDiffersFromTheUsual) {
  const SensorProfile table = value_of(
      read("roof.yaml",
           "# ours\nbeams_deg: [3, -1.5, 0.25]\nazimuth_step_deg: 0.1\nmax_range_m: 200\n"));
  EXPECT_EQ(table.name, "roof");
  EXPECT_EQ(table.beam_elevations_deg, (std::vector<double>{-1.5, 0.25, 3.0}));
  EXPECT_EQ(table.azimuth_step_deg, 0.1);
  EXPECT_EQ(table.max_range_m, 200.0);
  EXPECT_EQ(table.min_range_m, SensorProfile().min_range_m);
  const Result<SensorProfile> even =
      read("even.yml",
           "name: my-64\nbeams: 3\nlowest_beam_deg: -10\nhighest_beam_deg: 10\nheight_m: 2\n");
  EXPECT_EQ(even->beam_elevations_deg, (std::vector<double>{-10.0, 0.0, 10.0}));
  EXPECT_EQ(even->name, "my-64");
  EXPECT_EQ(even->height_m, 2.0);
  EXPECT_TRUE(even->sees_all_round());
  const SensorProfile ahead = value_of(
      read("ahead.yaml", "beams_deg: [-10, 10]\nazimuth_step_deg: 0.1\nazimuth_view_deg: 120\n"));
  EXPECT_EQ(ahead.azimuth_view_deg, 120.0);
  EXPECT_EQ(ahead.azimuth_count(), 1200);
}

TEST(SensorFile, OfAMakerIsReadAsItIs) {
  const Result<SensorProfile> hesai =
      read("correction.csv", "Channel,Elevation,Azimuth\n1,14.882,-1.042\n2,11.032,-1.042\n");
  EXPECT_EQ(hesai->beam_elevations_deg, (std::vector<double>{11.032, 14.882}));
  const SensorProfile ouster =
      value_of(read("os.json", R"({"beam_intrinsics": {"beam_altitude_angles": [20.1, 0.5, -21]},
        "config_params": {"lidar_mode": "2048x10"}, "sensor_info": {"prod_line": "OS-2-128"}})"));
  EXPECT_EQ(ouster.beam_elevations_deg, (std::vector<double>{-21.0, 0.5, 20.1}));
  EXPECT_EQ(ouster.azimuth_step_deg, 360.0 / 2048.0);
  EXPECT_EQ(ouster.max_range_m, 240.0);
  EXPECT_EQ(ouster.name, "OS-2-128");
}

TEST(SensorFile, RefusesWhatIsNoSensor) {
  const auto error_of = [](const char* name, const std::string& text) {
    return outcome_of(read(name, text));
  };
  EXPECT_THAT(error_of("a.yaml", "beams_deg: [1, x]\n"), HasSubstr("found 'x'"));
  EXPECT_THAT(error_of("a.yaml", "beams_deg: [1, 2]\nrange: 5\n"), HasSubstr("found 'range'"));
  EXPECT_THAT(error_of("a.yaml", "beams: 64\n"), HasSubstr("SL1004"));
  EXPECT_THAT(error_of("a.yaml", "beams: 1e9\nlowest_beam_deg: 0\nhighest_beam_deg: 1\n"),
              HasSubstr("expected 2 to 1024"));
  EXPECT_THAT(error_of("a.yaml", "beams_deg: [91, 92]\n"), HasSubstr("SL1003"));
  EXPECT_THAT(error_of("a.yaml", "beams_deg: [1]\n"), HasSubstr("found one beam"));
  for (const char* view : {"0", "0.1", "361", "-70"}) {
    EXPECT_THAT(error_of("a.yaml", std::string("beams_deg: [1, 2]\nazimuth_view_deg: ") + view),
                HasSubstr("the azimuth view is not within"))
        << view;
  }
  EXPECT_THAT(error_of("a.yaml", "hello\n"), HasSubstr("expected 'key: value'"));
  EXPECT_THAT(error_of("a.csv", "a,b\n1,2\n"), HasSubstr("found no column of elevations"));
  EXPECT_THAT(error_of("a.json", "{\"a\": 1}"), HasSubstr("beam_altitude_angles"));
  EXPECT_THAT(error_of("a.json", std::string(100'000, '[')), HasSubstr("too deep"));
}

}  // namespace
}  // namespace sightline
