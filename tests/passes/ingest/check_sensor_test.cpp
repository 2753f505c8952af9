#include "passes/ingest/check_sensor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/foreign/clouds/pcd_writer.h"
#include "formats/foreign/recording/open_recording.h"
#include "passes/ingest/ingest.h"
#include "tests/formats/foreign/foreign_files.h"
#include "tests/support/box_world.h"
#include "tests/support/test_context.h"

// Recordings of one LiDAR under the profile of another.

namespace sightline {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
constexpr double kRadians = std::numbers::pi / 180.0;

struct Lidar {
  std::vector<double> beams_deg;
  double smear_deg = 0.0;  // how far returns lie beside their beams, at most
  double azimuth_step_deg = 2.0;
  double range_m = 90.0;
  double view_deg = 360.0;  // half of it to each side of +x
};

Lidar lidar(const std::string& name) {
  const SensorProfile profile = *sensor_profile(name);
  return {profile.beam_elevations_deg, 0.0, 2.0, 90.0, profile.azimuth_view_deg};
}

std::vector<double> even_beams(int count, double lowest_deg, double highest_deg) {
  std::vector<double> beams_deg;
  for (int i = 0; i < count; ++i) {
    beams_deg.push_back(lowest_deg + (highest_deg - lowest_deg) * i / (count - 1));
  }
  return beams_deg;
}

std::vector<PointXyzi> scan(const BoxWorld& world, const Lidar& lidar, double at_x_m) {
  const Eigen::Vector3d origin_m(at_x_m, 0.0, 1.8);
  Random random(5);
  std::vector<PointXyzi> points;
  for (double azimuth_deg = 0.1; azimuth_deg < 360.0; azimuth_deg += lidar.azimuth_step_deg) {
    if (std::min(azimuth_deg, 360.0 - azimuth_deg) > 0.5 * lidar.view_deg) continue;
    for (const double beam_deg : lidar.beams_deg) {
      const double e_rad =
          (beam_deg + random.uniform(-lidar.smear_deg, lidar.smear_deg)) * kRadians;
      const double a_rad = azimuth_deg * kRadians;
      const Eigen::Vector3d direction(std::cos(e_rad) * std::cos(a_rad),
                                      std::cos(e_rad) * std::sin(a_rad), std::sin(e_rad));
      const double range_m = world.cast(origin_m, direction);
      if (range_m > lidar.range_m) continue;
      const Eigen::Vector3f p_m = (range_m * direction).cast<float>();
      points.push_back({p_m.x(), p_m.y(), p_m.z(), 0.0F});
    }
  }
  return points;
}

class CheckSensor : public testing::Test {
 protected:
  CheckSensor() { options_.scans = (folder_.path() / "scans").string(); }
  void record(const BoxWorld& world, const Lidar& lidar) {
    std::filesystem::create_directories(options_.scans);
    for (int i = 0; i < 2; ++i) {
      const std::filesystem::path file =
          std::filesystem::path(options_.scans) / (std::to_string(i) + ".pcd");
      ASSERT_TRUE(
          write_pcd_binary(file, scan(world, lidar, 3.0 * i), IfExists::kReplace).has_value());
    }
  }
  void give_beams(int count, double lowest_deg, double highest_deg) {
    options_.rings = count;
    options_.lowest_beam_deg = lowest_deg;
    options_.highest_beam_deg = highest_deg;
  }
  Result<Drive> read() {
    ctx_.warnings.clear();
    SIGHTLINE_ASSIGN(const Recording recording, open_recording(options_));
    return ingest(ctx_, {}, recording);
  }
  std::vector<std::string> warnings() {
    require(read());
    return ctx_.warnings;
  }

  ScratchFolder folder_;
  RecordingOptions options_;
  TestContext ctx_;
};

TEST_F(CheckSensor, SaysNothingOfARightProfileInStreetsAndInOpenCountry) {
  for (const std::string& name : sensor_profile_names()) {
    options_.sensor = name;
    for (const BoxWorld& world : {random_street(1), random_street(2), BoxWorld{}}) {
      record(world, lidar(name));
      EXPECT_THAT(warnings(), IsEmpty()) << name;
    }
  }
}

TEST_F(CheckSensor, SaysNothingOfRightBeamsThatAreSmeared) {
  options_.sensor = "hdl-64e";
  Lidar smeared = lidar("hdl-64e");
  smeared.smear_deg = 0.8;
  record(random_street(3), smeared);
  EXPECT_THAT(warnings(), IsEmpty());
}

TEST_F(CheckSensor, NamesWhatLiesOutsideAProfileThatNobodyChoseAndWhatInitWouldGuess) {
  record(random_street(1), lidar("hdl-64e"));
  EXPECT_THAT(warnings(),
              ElementsAre(AllOf(
                  HasSubstr("SL2025 unlike-profile"), HasSubstr("generic-16"),
                  HasSubstr("-15.0 to 15.0 degrees"), HasSubstr("% of the returns are outside"),
                  HasSubstr("-24.3 to 2.0 degrees"), HasSubstr("suggests `sensor: hdl-64e`"))));
}

TEST_F(CheckSensor, TellsOtherBeamsFromThoseOfTheProfileWithinTheSameFan) {
  record(random_street(1), lidar("generic-64"));
  EXPECT_THAT(warnings(),
              ElementsAre(AllOf(HasSubstr("the returns are at other elevations than these beams"),
                                HasSubstr("suggests `sensor: generic-64`"))));
  record(random_street(1), lidar("vlp-16"));
  options_.sensor = "generic-128";
  EXPECT_THAT(warnings(),
              ElementsAre(HasSubstr("the returns are at other elevations than these beams")));
}

TEST_F(CheckSensor, WarnsWhereBeamsGoOnFarBeyondTheReturns) {
  Lidar smeared = lidar("hdl-64e");
  smeared.smear_deg = 0.5;
  record(random_street(1), smeared);
  give_beams(64, -24.0, 16.0);
  EXPECT_THAT(warnings(),
              ElementsAre(HasSubstr("the highest returns are far below the highest beam")));
  smeared = lidar("vlp-16");
  smeared.smear_deg = 1.0;
  record(random_street(1), smeared);
  give_beams(64, -24.0, 16.0);
  EXPECT_THAT(warnings(),
              ElementsAre(HasSubstr("the lowest beams have no returns from the ground")));
}

TEST_F(CheckSensor, WarnsOfManyMoreReturnsThanTheProfileHasRays) {
  Lidar smeared{even_beams(128, -14.0, -2.0), 0.05, 0.5};
  record(random_street(1), smeared);
  options_.sensor = "vlp-16";
  EXPECT_THAT(warnings(),
              ElementsAre(AllOf(HasSubstr("SL2025"),
                                HasSubstr("times as many returns as these have rays"))));
}

TEST_F(CheckSensor, WarnsOfReturnsBeyondTheRangeOfTheProfile) {
  Lidar far = lidar("generic-16");
  far.range_m = 400.0;
  BoxWorld world;
  world.boxes = {{{150.0, -300.0, 0.0}, {160.0, 300.0, 60.0}}};
  record(world, far);
  EXPECT_THAT(warnings(), ElementsAre(HasSubstr("are beyond its range of 100 m")));
}

TEST_F(CheckSensor, RefusesAProfileThatMostReturnsContradict) {
  record(random_street(1), lidar("hdl-64e"));
  give_beams(16, 0.0, 30.0);
  const Error refused = failure_of(read());
  EXPECT_EQ(refused.code, ErrorCode::kUnlikeProfile);
  EXPECT_THAT(refused.message,
              AllOf(HasSubstr("0.0 to 30.0 degrees"), HasSubstr("suggests `sensor: hdl-64e`")));
}

TEST_F(CheckSensor, SaysNothingOfAHandfulOfReturns) {
  record(BoxWorld{}, {{-40.0, -30.0}, 0.0, 2.0, 90.0});
  EXPECT_THAT(warnings(), IsEmpty());
}

TEST_F(CheckSensor, NamesReturnsOutsideTheAzimuthView) {
  Lidar wide = lidar("livox-avia");
  wide.view_deg = 80.0;
  wide.azimuth_step_deg = 1.0;
  record(random_street(1), wide);
  options_.sensor = "livox-avia";
  EXPECT_THAT(
      warnings(),
      ElementsAre(HasSubstr("% of the returns are outside its azimuth view of 70.4 degrees")));
}

TEST_F(CheckSensor, RefusesAViewThatMostReturnsLieOutsideOf) {
  options_.sensor = "generic-64";
  options_.azimuth_view_deg = 90.0;
  record(random_street(1), lidar("generic-64"));
  EXPECT_EQ(failure_of(read()).code, ErrorCode::kUnlikeProfile);
}

TEST_F(CheckSensor, NamesASectorThatReturnsFillWhereTheProfileSeesAllRound) {
  Lidar cropped = lidar("hdl-64e");
  cropped.view_deg = 90.0;
  record(random_street(1), cropped);
  options_.sensor = "hdl-64e";
  EXPECT_THAT(warnings(),
              ElementsAre(AllOf(HasSubstr("all returns are within 88.3"),
                                HasSubstr("but its view is 360 degrees"),
                                HasSubstr("suggests `sensor: hdl-64e`, `azimuth_view_deg: 88.3"))));
  options_.azimuth_view_deg = 90.0;
  EXPECT_THAT(warnings(), IsEmpty());
}

}  // namespace
}  // namespace sightline
