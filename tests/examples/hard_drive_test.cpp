#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "examples/town/bag/imu.h"
#include "examples/town/write_town.h"
#include "formats/base/files/atomic_file.h"
#include "formats/base/hash.h"
#include "formats/foreign/recording/open_recording.h"
#include "formats/foreign/ros/files/open_message_log.h"
#include "tests/examples/hard_world.h"
#include "tests/support/scratch_folder.h"

namespace sightline::town {
namespace {

DriveSimulator swept_drive(const Town& town) {
  DriveOptions options = hard_drive_options(town);
  options.is_swept = true;
  return value_of(DriveSimulator::make(town, options));
}

double speed_m_s(const DriveSimulator& drive, double time_s) {
  const Pose before = drive.T_town_vehicle_at(time_s - 0.01);
  const Pose after = drive.T_town_vehicle_at(time_s + 0.01);
  return (after.translation() - before.translation()).norm() / 0.02;
}

TEST(HardDrive, ChangesItsSpeedByFivePercent) {
  const Town town = hard_town("field", 300.0);
  const DriveSimulator drive = swept_drive(town);
  double slowest_m_s = 10.0;
  double fastest_m_s = 10.0;
  for (double time_s = 0.1; time_s < 29.0; time_s += 0.5) {
    slowest_m_s = std::min(slowest_m_s, speed_m_s(drive, time_s));
    fastest_m_s = std::max(fastest_m_s, speed_m_s(drive, time_s));
    const double wave = std::sin(2.0 * std::numbers::pi * time_s / 20.0);
    EXPECT_NEAR(speed_m_s(drive, time_s), 10.0 * (1.0 + 0.05 * wave), 0.02) << time_s;
  }
  EXPECT_NEAR(slowest_m_s, 9.5, 0.03);
  EXPECT_NEAR(fastest_m_s, 10.5, 0.03);
  EXPECT_LE(drive.driven_m(drive.scan_count() - 1), 300.0 + 1e-9);
  EXPECT_GT(drive.driven_m(drive.scan_count()), 300.0);
}

TEST(HardDrive, WheelsMeasureTheSpeedOfThePosesButForScaleAndNoise) {
  const Town town = hard_town("car-park", 300.0);
  const DriveSimulator drive = swept_drive(town);
  const std::vector<WheelSpeed> speeds = wheel_speeds(drive, 7);
  ASSERT_EQ(speeds.size(), 5 * drive.scan_count() + 1);
  double measured_m = 0.0;
  double true_m = 0.0;
  double squares = 0.0;
  for (const WheelSpeed& speed : speeds) {
    const double time_s = 1e-9 * static_cast<double>(speed.stamp_ns);
    measured_m += 0.02 * speed.speed_m_s;
    true_m += 0.02 * speed_m_s(drive, time_s);
    const Eigen::Matrix3d turn = drive.T_town_vehicle_at(time_s - 0.002).linear().transpose() *
                                 drive.T_town_vehicle_at(time_s + 0.002).linear();
    const double rate_rad_s = rotation_vector(turn).z() / 0.004;
    squares += std::pow(speed.yaw_rate_rad_s - rate_rad_s, 2);
    ASSERT_NEAR(speed.speed_m_s, speed_m_s(drive, time_s), 0.3) << time_s;
  }
  EXPECT_NEAR(measured_m / true_m, 1.0, 0.016);
  EXPECT_GT(std::abs(measured_m / true_m - 1.0), 1e-4) << "a scale of its own";
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(speeds.size())), 0.02, 0.01);
}

TEST(HardDrive, TheImuMeasuresTheAccelerationOfThePosesAndGravity) {
  constexpr std::size_t kMean = 20;
  const Town town = hard_town("hills", 300.0);
  const DriveSimulator drive = swept_drive(town);
  const std::vector<TurnRate> rates = imu_of(drive, 7);
  const std::vector<Eigen::Vector3d> forces = specific_forces(drive, 7, rates);
  ASSERT_EQ(forces.size(), rates.size());
  const auto imu_at = [&](double time_s) -> Pose {
    return drive.T_town_vehicle_at(time_s) * T_vehicle_imu();
  };
  const auto velocity = [&](double time_s) -> Eigen::Vector3d {
    return (imu_at(time_s + 1e-3).translation() - imu_at(time_s - 1e-3).translation()) / 2e-3;
  };
  // In the middle of the drive; means of a tenth of a second against the change of the velocity.
  for (std::size_t i = 2000; i + kMean < 4000; i += kMean) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (std::size_t k = i; k < i + kMean; ++k) mean += forces[k] / kMean;
    const double from_s = 1e-9 * static_cast<double>(rates[i].stamp_ns) - 0.0025;
    const Eigen::Vector3d change = (velocity(from_s + 0.1) - velocity(from_s)) / 0.1;
    const Eigen::Vector3d expected =
        imu_at(from_s + 0.05).linear().transpose() * (change + Eigen::Vector3d(0.0, 0.0, 9.80665));
    ASSERT_LT((mean - expected).norm(), 0.2) << from_s << ": bias, noise and turns";
  }
}

TEST(HardDrive, FogTravelsWithTheSensor) {
  const Town town = hard_town("field", 200.0);
  DriveOptions options = hard_drive_options(town);
  options.has_fog = true;
  const DriveSimulator drive = value_of(DriveSimulator::make(town, options));
  const auto ray_of = [](const LabelledPoint& point) {
    const Eigen::Vector3d ray = point.position_m.cast<double>().normalized();
    return std::pair(std::lround(2000.0 * std::atan2(ray.y(), ray.x())),
                     std::lround(100.0 * ray.z()));
  };
  std::map<std::pair<long, long>, double> ranges_m;
  const TownScan first = drive.scan(20);
  std::size_t fog = 0;
  for (const LabelledPoint& point : first.points) {
    if (point.label != Label::kFog) continue;
    ++fog;
    ranges_m[ray_of(point)] = point.position_m.norm();
  }
  EXPECT_GT(fog, first.points.size() / 50);
  EXPECT_LT(fog, first.points.size() / 3);
  std::size_t again = 0;
  for (const LabelledPoint& point : drive.scan(60).points) {
    if (point.label != Label::kFog) continue;
    const auto before = ranges_m.find(ray_of(point));
    if (before == ranges_m.end()) continue;
    again += std::abs(before->second - point.position_m.norm()) < 0.15 ? 1 : 0;
  }
  EXPECT_GT(again, fog / 3) << "40 % of its returns fail to come, each time others";
}

TEST(HardDrive, ACoveredPartOfTheViewIsEmptyAndTheRestAsBefore) {
  const Town town = hard_town("forest", 120.0);
  DriveOptions options = hard_drive_options(town);
  const TownScan whole = value_of(DriveSimulator::make(town, options)).scan(50);
  options.covered_deg = 121.0;
  const TownScan covered = value_of(DriveSimulator::make(town, options)).scan(50);
  std::vector<Eigen::Vector3f> expected;
  for (const LabelledPoint& point : whole.points) {
    const double azimuth_rad = std::atan2(point.position_m.y(), point.position_m.x());
    if (std::abs(azimuth_rad) < to_radians(119.5)) expected.push_back(point.position_m);
  }
  ASSERT_LT(expected.size(), whole.points.size());
  EXPECT_TRUE(std::ranges::equal(covered.points, expected, {}, &LabelledPoint::position_m));
  options.covered_deg = 360.0;
  EXPECT_EQ(code_of(DriveSimulator::make(town, options)), ErrorCode::kBadArgument);
}

TEST(HardDrive, LorriesDriveBesideTheVehicleAndNothingOverIt) {
  for (const std::string_view world : {"motorway", "tunnel", "bridge", "field"}) {
    const Town town = hard_town(world, 300.0);
    const DriveSimulator drive = value_of(DriveSimulator::make(town, hard_drive_options(town, 1)));
    std::size_t beside = 0;
    for (std::size_t i = 0; i < drive.scan_count(); ++i) {
      bool is_beside = false;
      for (const Eigen::Vector3f& vertex : drive.moving_mesh_at(i).vertices_m) {
        const Eigen::Vector3d off_m = drive.T_town_vehicle()[i].inverse() * vertex.cast<double>();
        ASSERT_GT(off_m.head<2>().norm(), 1.2) << world << " " << i;
        is_beside |= std::abs(off_m.x()) < 4.0 && off_m.z() > 3.0;
      }
      beside += is_beside ? 1 : 0;
    }
    if (world == "field") {
      EXPECT_EQ(beside, 0U);
    } else {
      EXPECT_GT(beside, 10U) << world;
    }
  }
}

class HardFiles : public TestInFolder {
 protected:
  WriteTownOptions options(const std::string& name, std::string_view world) const {
    WriteTownOptions options;
    options.town = hard_options(world, 120.0);
    options.out = folder_ / name;
    options.drives = 0;
    options.spacing_m = 4.0;
    options.is_swept = true;
    return options;
  }
};

TEST_F(HardFiles, HoldPlacesPosesAndABagWithWheelSpeed) {
  WriteTownOptions written = options("one", "tunnel");
  written.constraints_m = 60.0;
  require(write_town(written));
  WriteTownOptions again = options("two", "tunnel");
  again.threads = 2;
  require(write_town(again));
  EXPECT_EQ(value_of(read_file(written.out / "mapping/drive.mcap")),
            value_of(read_file(again.out / "mapping/drive.mcap")));
  EXPECT_EQ(value_of(read_text_file(written.out / "places.csv")),
            "from_m,to_m,kind\n0.000,40.000,town\n40.000,80.000,tunnel\n80.000,120.000,town\n");
  const std::string scans = value_of(read_text_file(written.out / "mapping/scans.csv"));
  EXPECT_EQ(scans.substr(0, 40), "scan,driven_m,kind\n0,0.000000,town\n1,4.0");
  EXPECT_EQ(std::ranges::count(scans, '\n'), 1 + 30);
  const std::string found = value_of(read_text_file(written.out / "mapping/constraints.csv"));
  EXPECT_EQ(std::ranges::count(found, '\n'), 1 + 2);
  EXPECT_NE(value_of(read_text_file(written.out / "town.json")).find("\"world\": \"tunnel\""),
            std::string::npos);

  const auto log = value_of(open_message_log(written.out / "mapping/drive.mcap"));
  std::map<std::string, std::uint64_t> counts;
  for (const auto& [number, channel] : log->channels()) counts[channel.type] = number;
  ASSERT_TRUE(counts.contains("geometry_msgs/TwistStamped"));
  std::vector<std::int64_t> stamps_ns;
  require(log->for_each_message({static_cast<std::uint32_t>(counts["geometry_msgs/TwistStamped"])},
                                [&](const LoggedMessage& message) -> Result<void> {
                                  stamps_ns.push_back(message.time_ns);
                                  return {};
                                }));
  EXPECT_EQ(stamps_ns.size(), 30U * 5U + 1U);
  EXPECT_TRUE(std::ranges::is_sorted(stamps_ns));

  RecordingOptions recorded;
  recorded.scans = (written.out / "mapping/drive.mcap").string();
  recorded.poses = recorded.scans;
  recorded.lidar_z_m = 1.8;
  const Recording recording = value_of(open_recording(recorded));
  EXPECT_TRUE(recording.warnings.empty()) << recording.warnings.front();
  EXPECT_EQ(recording.scans.size(), 30U);
  EXPECT_GT(recording.turn_rates.size(), 600U);
}

// What every earlier version wrote for a town of streets.
TEST_F(HardFiles, OfATownOfStreetsAreTheBytesOfBefore) {
  WriteTownOptions town = options("town", "town");
  town.town = {4, 20.0};
  town.spacing_m = 5.0;
  town.is_swept = false;
  require(write_town(town));
  const auto digest_of = [&](const WriteTownOptions& options, const std::string& name) {
    return to_hex(sha256(value_of(read_file(options.out / name))));
  };
  EXPECT_EQ(digest_of(town, "mapping/scans/000002.pcd"),
            "86ce98b544a9955aa86e9ebe0c0f92284c5d55f0abfaecc29ce46a0807c447d5");
  EXPECT_EQ(digest_of(town, "mapping/poses.tum"),
            "f873df54cf6711f41ea44b8ca82f2366cc4fe57befa9658e20d43c71f2125774");
  EXPECT_EQ(digest_of(town, "town.json"),
            "19f26af5ecea6cf4457eac52bdc68c1bb6b8e0207915160d1e2e0bac9e9e80e6");
  EXPECT_FALSE(std::filesystem::exists(town.out / "places.csv"));
  WriteTownOptions swept = town;
  swept.out = folder_ / "swept";
  swept.is_swept = true;
  require(write_town(swept));
  EXPECT_EQ(digest_of(swept, "mapping/drive.mcap"),
            "03088634f4d145bb1eb73df783cc8db27d98800d84bdd90e48fd7f87a939a6f9");
}

}  // namespace
}  // namespace sightline::town
