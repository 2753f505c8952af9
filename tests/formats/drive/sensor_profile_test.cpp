#include "formats/drive/sensor_profile.h"

#include <algorithm>
#include <limits>
#include <tuple>

#include "tests/support/artifact_checks.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

TEST(SensorProfile, EveryBuiltInProfileIsValidAndSurvivesDisk) {
  ASSERT_EQ(sensor_profile_names().size(), 28U);
  for (const std::string& name : sensor_profile_names()) {
    const SensorProfile profile = value_of(sensor_profile(name), name);
    EXPECT_EQ(profile.name, name);
    EXPECT_TRUE(validate(profile).has_value()) << name;
  }
  expect_survives_disk(*sensor_profile("generic-16"));
  expect_survives_disk(*sensor_profile("livox-avia"));
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
  EXPECT_EQ(beams("pandar128").front(), -25.016);
  EXPECT_EQ(beams("pandar128").at(86), 0.0);
  EXPECT_EQ(beams("pandar128").back(), 14.436);
  EXPECT_EQ(beams("vlp-32c").size(), 32U);
  EXPECT_EQ(beams("vls-128").size(), 128U);
  EXPECT_EQ(beams("vls-128").at(11), -6.65);
  EXPECT_EQ(beams("vls-128").at(115), 4.83);
  EXPECT_EQ(beams("vls-128").at(116), 4.98);
  EXPECT_EQ(beams("xt32").at(1) - beams("xt32").at(0), 1.0);
  EXPECT_EQ(beams("os2-32").back(), 11.25);
  EXPECT_EQ(beams("rs-helios-5515").size(), 32U);
  EXPECT_EQ(beams("rs-helios-5515").front(), -55.0);
  EXPECT_EQ(beams("rs-helios-5515").at(15), -10.0);
  EXPECT_EQ(beams("rs-ruby-128").size(), 128U);
  EXPECT_EQ(beams("rs-ruby-128").at(13), -6.39);
  EXPECT_EQ(beams("rs-ruby-128").at(115), 3.81);
}

TEST(SensorProfile, RefusesAnUnknownNameAndListsTheKnown) {
  const Error error = failure_of(sensor_profile("vlp16"));
  EXPECT_EQ(error.code, ErrorCode::kUnknownName);
  EXPECT_NE(error.message.find("vlp-16"), std::string::npos);
}

TEST(SensorProfile, ListsTheProfilesOfAMakerThatIsNamedAlone) {
  for (const auto& [name, own, other] :
       {std::tuple("Velodyne", " hdl-64e", " os1-64"), std::tuple("ouster", " os1-64", " hdl-64e"),
        std::tuple("Hesai", " pandar64", " vlp-16"), std::tuple("livox", " livox-avia", " xt16"),
        std::tuple("RoboSense", " rs-ruby-128", " xt16")}) {
    const std::string message = failure_of(sensor_profile(name), name).message;
    EXPECT_NE(message.find(own), std::string::npos) << message;
    EXPECT_EQ(message.find(other), std::string::npos) << message;
    EXPECT_EQ(message.find("did you mean"), std::string::npos) << message;
  }
}

TEST(SensorProfile, RefusesWhatNoSensorIs) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  expect_refused<SensorProfile>(
      *sensor_profile("generic-16"),
      {[](SensorProfile& profile) { profile.beam_elevations_deg.clear(); },
       [](SensorProfile& profile) {
         std::swap(profile.beam_elevations_deg[0], profile.beam_elevations_deg[1]);
       },
       [](SensorProfile& profile) { profile.beam_elevations_deg[3] = kNan; },
       [](SensorProfile& profile) { profile.azimuth_step_deg = 0.0; },
       [](SensorProfile& profile) { profile.azimuth_view_deg = 0.0; },
       [](SensorProfile& profile) { profile.azimuth_view_deg = 0.1; },
       [](SensorProfile& profile) { profile.azimuth_view_deg = 361.0; },
       [](SensorProfile& profile) { profile.azimuth_view_deg = kNan; },
       [](SensorProfile& profile) { profile.max_range_m = profile.min_range_m; },
       [](SensorProfile& profile) { profile.T_vehicle_lidar.linear() *= 2.0; }});
}

TEST(SensorProfile, OfALivoxAviaSees70DegreesAheadEvenly) {
  const SensorProfile avia = *sensor_profile("livox-avia");
  EXPECT_FALSE(avia.sees_all_round());
  EXPECT_EQ(avia.azimuth_count() * avia.ring_count(), 24'000);
  EXPECT_NEAR(avia.azimuth_deg(0), -34.98, 1e-9);
  EXPECT_NEAR(avia.azimuth_deg(159), 34.98, 1e-9);
  EXPECT_NEAR(avia.azimuth_deg(80) - avia.azimuth_deg(79), 0.44, 1e-9);
  EXPECT_EQ(avia.beam_elevations_deg.front(), -avia.beam_elevations_deg.back());
  const SensorProfile round = *sensor_profile("vlp-16");
  EXPECT_TRUE(round.sees_all_round());
  EXPECT_EQ(round.azimuth_count(), 1800);
  EXPECT_EQ(round.azimuth_deg(0), 0.0);
  EXPECT_EQ(round.azimuth_deg(450), 450 * 0.2);
}

TEST(SensorProfile, ThatSeesAllRoundHasTheBytesItAlwaysHad) {
  const SensorProfile round = *sensor_profile("vlp-16");
  ByteWriter expected;
  expected.put_string(round.name);
  expected.put_array(round.beam_elevations_deg);
  for (const double number : {0.2, 1.0, 100.0, 1.8}) expected.put(number);
  encode(round.T_vehicle_lidar, expected);
  ByteWriter writer;
  encode(round, writer);
  EXPECT_TRUE(std::ranges::equal(writer.bytes(), expected.bytes()));
  EXPECT_EQ(dump(round).facts.size(), 5U + 12U);
  EXPECT_EQ(dump(*sensor_profile("livox-avia")).facts.size(), 6U + 12U);
}

}  // namespace
}  // namespace sightline
