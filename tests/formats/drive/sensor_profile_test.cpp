#include "formats/drive/sensor_profile.h"

#include <limits>

#include "tests/support/artifact_checks.h"

namespace sightline {
namespace {

TEST(SensorProfile, EveryBuiltInProfileIsValidAndSurvivesDisk) {
  ASSERT_EQ(sensor_profile_names().size(), 25U);
  for (const std::string& name : sensor_profile_names()) {
    const Result<SensorProfile> profile = sensor_profile(name);
    ASSERT_TRUE(profile.has_value()) << name;
    EXPECT_EQ(profile->name, name);
    EXPECT_TRUE(validate(*profile).has_value()) << name;
  }
  expect_survives_disk(*sensor_profile("generic-16"));
}

TEST(SensorProfile, HasTheBeamsOfTheMakersTables) {
  const auto beams = [](const char* name) { return sensor_profile(name)->beam_elevations_deg; };
  EXPECT_EQ(beams("vlp-16").size(), 16U);
  EXPECT_NEAR(beams("vlp-16").at(1), -13.0, 1e-12);
  EXPECT_NEAR(beams("vlp-16").back(), 15.0, 1e-12);
  EXPECT_EQ(beams("hdl-32e").size(), 32U);
  EXPECT_NEAR(beams("hdl-32e").at(1), -29.34, 0.01);
  EXPECT_EQ(beams("hdl-64e").size(), 64U);
  EXPECT_NEAR(beams("hdl-64e").at(1) - beams("hdl-64e").at(0), 0.5, 1e-12);
  EXPECT_NEAR(beams("hdl-64e").at(63) - beams("hdl-64e").at(62), 1.0 / 3.0, 1e-3);
  EXPECT_EQ(beams("os1-64").size(), 64U);
  EXPECT_NEAR(beams("os1-64").front(), -16.6, 1e-12);
  EXPECT_EQ(beams("generic-128").size(), 128U);
  EXPECT_EQ(beams("pandar64").size(), 64U);
  EXPECT_EQ(beams("pandar64").front(), -25.0);
  EXPECT_EQ(beams("pandar64").at(58), 2.0);
  EXPECT_EQ(beams("pandar128").size(), 128U);
  EXPECT_EQ(beams("vlp-32c").size(), 32U);
  EXPECT_EQ(beams("vls-128").size(), 128U);
  EXPECT_EQ(beams("vls-128").at(11), -6.65);
  EXPECT_EQ(beams("vls-128").at(115), 4.83);
  EXPECT_EQ(beams("vls-128").at(116), 4.98);
  EXPECT_EQ(beams("xt32").at(1) - beams("xt32").at(0), 1.0);
  EXPECT_EQ(beams("os2-32").back(), 11.25);
}

TEST(SensorProfile, RefusesAnUnknownNameAndListsTheKnown) {
  const Result<SensorProfile> profile = sensor_profile("vlp16");
  ASSERT_FALSE(profile.has_value());
  EXPECT_EQ(profile.error().code, ErrorCode::kUnknownName);
  EXPECT_NE(profile.error().message.find("vlp-16"), std::string::npos);
}

TEST(SensorProfile, RefusesWhatNoSensorIs) {
  const SensorProfile good = *sensor_profile("generic-16");
  const auto expect_refused = [](const SensorProfile& profile) {
    EXPECT_EQ(validate(profile).error().code, ErrorCode::kInvalidArtifact);
  };
  SensorProfile profile = good;
  profile.beam_elevations_deg.clear();
  expect_refused(profile);
  profile = good;
  std::swap(profile.beam_elevations_deg[0], profile.beam_elevations_deg[1]);
  expect_refused(profile);
  profile = good;
  profile.beam_elevations_deg[3] = std::numeric_limits<double>::quiet_NaN();
  expect_refused(profile);
  profile = good;
  profile.azimuth_step_deg = 0.0;
  expect_refused(profile);
  profile = good;
  profile.max_range_m = profile.min_range_m;
  expect_refused(profile);
  profile = good;
  profile.T_vehicle_lidar.linear() *= 2.0;
  expect_refused(profile);
}

}  // namespace
}  // namespace sightline
