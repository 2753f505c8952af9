#include "examples/town/drive/drive.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "tests/support/value_of.h"

namespace sightline::town {
namespace {

constexpr double kShortM = 24.0;

class TownDrive : public testing::Test {
 protected:
  static void SetUpTestSuite() { town_ = new Town(*make_town({21, 200.0})); }
  static void TearDownTestSuite() {
    delete town_;
    town_ = nullptr;
  }
  static DriveOptions options_of(std::uint64_t drive, double length_m = kShortM) {
    DriveOptions options = usual_drive(town_->options, drive, *town_sensor(16));
    options.length_m = length_m;
    return options;
  }
  static DriveSimulator simulator(const DriveOptions& options) {
    return value_of(DriveSimulator::make(*town_, options));
  }
  static inline Town* town_ = nullptr;
};

bool same_points(const TownScan& a, const TownScan& b) {
  return std::equal(a.points.begin(), a.points.end(), b.points.begin(), b.points.end(),
                    [](const LabelledPoint& p, const LabelledPoint& q) {
                      return p.position_m == q.position_m && p.intensity == q.intensity &&
                             p.label == q.label;
                    });
}

TEST_F(TownDrive, AScanIsTheSameWhateverWasAskedForBefore) {
  const DriveSimulator drive = simulator(options_of(0, 6.0));
  const std::vector<TownScan> one = simulate(drive, 1);
  const std::vector<TownScan> two = simulate(drive, 2);
  ASSERT_EQ(one.size(), 7U);
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_TRUE(same_points(one[i], two[i])) << i;
  EXPECT_TRUE(same_points(one[4], drive.scan(4)));
}

TEST_F(TownDrive, MayComeBackAndKeepToTheNextLaneWhereThereIsOne) {
  DriveOptions options = usual_drive(town_->options, 0, *town_sensor(16));
  options.is_back = true;
  options.is_in_next_lane = true;
  const DriveSimulator drive = simulator(options);
  ASSERT_EQ(drive.scan_count(), 201U);
  EXPECT_EQ(drive.driven_m(0), 200.0);
  double before_m = 0.0;
  double most_m = 0.0;
  for (std::size_t i = 0; i < drive.scan_count(); ++i) {
    const LinePoint point = town_->plan.line.at(200.0 - static_cast<double>(i));
    const Pose& pose = drive.T_town_vehicle()[i];
    const Eigen::Vector2d ahead(std::cos(point.heading_rad), std::sin(point.heading_rad));
    const Eigen::Vector2d off_m = pose.translation().head<2>() - point.position_m;
    const double lateral_m = ahead.x() * off_m.y() - ahead.y() * off_m.x();
    EXPECT_NEAR(off_m.dot(ahead), 0.0, 1e-9);
    EXPECT_LT(pose.linear().col(0).head<2>().dot(ahead), -0.9);
    EXPECT_TRUE(lateral_m > -1e-9 && lateral_m < kNextLane_m + 1e-9) << lateral_m;
    if (!has_next_lane(*town_, drive.driven_m(i))) {
      EXPECT_NEAR(lateral_m, 0.0, 1e-9) << i;
    }
    if (i > 0) {
      EXPECT_LT(std::abs(lateral_m - before_m), 0.4) << i;
    }
    before_m = lateral_m;
    most_m = std::max(most_m, lateral_m);
  }
  EXPECT_NEAR(most_m, kNextLane_m, 1e-9);
}

TEST_F(TownDrive, RangeNoiseIsCentredAndAsWideAsAskedFor) {
  for (const std::uint64_t number : {0ULL, 1ULL, 2ULL}) {
    const DriveOptions options = options_of(number, 2.0);
    const DriveSimulator drive = simulator(options);
    const TownScan scan = drive.scan(1);
    const Pose T_town_lidar = scan.T_town_vehicle * options.sensor.T_vehicle_lidar;
    double sum = 0.0;
    double squares = 0.0;
    int count = 0;
    for (const LabelledPoint& point : scan.points) {
      if (is_moving(point.label)) continue;
      const Eigen::Vector3d p = point.position_m.cast<double>();
      const Eigen::Vector3d ray = T_town_lidar.linear() * p.normalized();
      const double off_m =
          p.norm() - drive.standing().exact_range_m(T_town_lidar.translation(), ray);
      if (std::abs(off_m) > 0.2) continue;  // float coordinates moved the ray past an edge
      sum += off_m;
      squares += off_m * off_m;
      ++count;
    }
    ASSERT_GT(count, 5000);
    EXPECT_NEAR(sum / count, 0.0, 0.001);
    EXPECT_NEAR(std::sqrt(squares / count), options.range_sigma_m, 0.001);
  }
}

TEST_F(TownDrive, ReturnsLieOnTheSensorsRingsAndWithinItsRange) {
  const TownScan scan = simulator(options_of(0, 2.0)).scan(0);
  for (const LabelledPoint& point : scan.points) {
    const Eigen::Vector3d p = point.position_m.cast<double>();
    const double elevation_deg = std::atan2(p.z(), p.head<2>().norm()) * 180.0 / std::numbers::pi;
    const double ring = (elevation_deg + 15.0) / 2.0;
    ASSERT_NEAR(ring, std::round(ring), 1e-3);
    ASSERT_GE(p.norm(), 0.499);
    ASSERT_LE(p.norm(), 100.001);
    ASSERT_GE(point.intensity, 0.0F);
    ASSERT_LE(point.intensity, 255.0F);
  }
}

TEST_F(TownDrive, OfAPartOfTheRouteBeginsThere) {
  DriveOptions options = options_of(1, 40.0);
  const DriveSimulator whole = simulator(options);
  options.from_m = 20.0;
  options.length_m = 15.0;
  const DriveSimulator part = simulator(options);
  ASSERT_EQ(part.scan_count(), 16u);
  EXPECT_EQ(part.driven_m(3), 23.0);
  for (std::size_t i = 0; i < part.scan_count(); ++i) {
    EXPECT_TRUE(part.T_town_vehicle()[i].matrix() == whole.T_town_vehicle()[i + 20].matrix());
  }
  options.from_m = 190.0;
  EXPECT_FALSE(DriveSimulator::make(*town_, options).has_value());
}

TEST_F(TownDrive, SomeReturnsAreMissing) {
  const auto count = static_cast<double>(simulator(options_of(0, 2.0)).scan(0).points.size());
  EXPECT_LT(count, 0.97 * 28800);
  EXPECT_GT(count, 0.40 * 28800);
}

TEST_F(TownDrive, WhatMovesDiffersBetweenScansAndIsSeen) {
  const DriveSimulator drive = simulator(options_of(0, 190.0));
  const TownMesh first = drive.moving_mesh_at(10);
  const TownMesh later = drive.moving_mesh_at(11);
  ASSERT_FALSE(first.triangles.empty());
  EXPECT_TRUE(std::all_of(first.labels.begin(), first.labels.end(), is_moving));
  EXPECT_NE(first.vertices_m, later.vertices_m);
  std::size_t seen = 0;
  for (std::size_t i = 0; i < drive.scan_count(); i += 20) {
    const TownScan scan = drive.scan(i);
    seen += static_cast<std::size_t>(
        std::count_if(scan.points.begin(), scan.points.end(),
                      [](const LabelledPoint& point) { return is_moving(point.label); }));
  }
  EXPECT_GT(seen, 200U);
}

TEST_F(TownDrive, TrafficLeavesTracesOnTheDrivenLine) {
  const DriveSimulator drive = simulator(options_of(0, 190.0));
  std::size_t on_line = 0;
  for (std::size_t i = 0; i < drive.scan_count(); i += 5) {
    for (const Eigen::Vector3f& vertex : drive.moving_mesh_at(i).vertices_m) {
      for (const Pose& pose : drive.T_town_vehicle()) {
        const Eigen::Vector3d away = vertex.cast<double>() - pose.translation();
        if (away.head<2>().norm() < 1.0) ++on_line;
      }
    }
  }
  EXPECT_GT(on_line, 100U);
}

TEST_F(TownDrive, NothingThatMovesDrivesOverTheSensor) {
  for (const std::uint64_t number : {0ULL, 1ULL, 2ULL}) {
    const DriveSimulator drive = simulator(options_of(number, 190.0));
    for (std::size_t i = 0; i < drive.scan_count(); ++i) {
      for (const Eigen::Vector3f& vertex : drive.moving_mesh_at(i).vertices_m) {
        const Eigen::Vector3d away =
            vertex.cast<double>() - drive.T_town_vehicle()[i].translation();
        ASSERT_GT(away.head<2>().norm(), 1.2) << "drive " << number << ", scan " << i;
      }
    }
  }
}

TEST_F(TownDrive, FiveTimesTheTrafficIsAboutFiveTimesAsManyAndDrivesOverNobody) {
  const auto count_of = [](const std::vector<Mover>& movers, Mover::Role role) {
    return static_cast<double>(std::ranges::count(movers, role, &Mover::role));
  };
  const Town town = *make_town({21, 2000.0});
  const std::vector<Mover> usual = draw_traffic(town, 2, 200.0);
  const std::vector<Mover> crowd = draw_traffic(town, 2, 200.0, 5.0);
  for (const Mover::Role role : {Mover::Role::kOncoming, Mover::Role::kPedestrian}) {
    EXPECT_NEAR(count_of(crowd, role) / count_of(usual, role), 5.0, 0.5);
  }
  // No more than one can be ahead at a time: it is there nearly always instead of half the time.
  EXPECT_GT(count_of(crowd, Mover::Role::kLeader), 1.3 * count_of(usual, Mover::Role::kLeader));

  DriveOptions options = options_of(2, 190.0);
  options.traffic = 5.0;
  const DriveSimulator drive = simulator(options);
  for (std::size_t i = 0; i < drive.scan_count(); i += 3) {
    for (const Eigen::Vector3f& vertex : drive.moving_mesh_at(i).vertices_m) {
      const Eigen::Vector3d away = vertex.cast<double>() - drive.T_town_vehicle()[i].translation();
      ASSERT_GT(away.head<2>().norm(), 1.2) << "scan " << i;
    }
  }
}

TEST_F(TownDrive, AShareOfReturnsGoesMissingAndTheOthersStayAsTheyWere) {
  DriveOptions options = options_of(1, 3.0);
  const TownScan whole = simulator(options).scan(2);
  options.missing_share = 0.3;
  const TownScan rest = simulator(options).scan(2);
  const double share =
      static_cast<double>(rest.points.size()) / static_cast<double>(whole.points.size());
  EXPECT_NEAR(share, 0.7, 0.01);
  std::size_t next = 0;
  for (const LabelledPoint& point : whole.points) {
    if (next < rest.points.size() && rest.points[next].position_m == point.position_m) ++next;
  }
  EXPECT_EQ(next, rest.points.size());
}

TEST_F(TownDrive, DrivesMeetOtherCarsAndRunBesideEachOther) {
  const DriveSimulator mapping = simulator(options_of(0));
  const DriveSimulator first = simulator(options_of(1));
  const DriveSimulator second = simulator(options_of(2));
  EXPECT_FALSE(same_points(mapping.scan(3), first.scan(3)));
  const Pose T_vehicle_town = mapping.T_town_vehicle()[0].inverse();
  const Eigen::Vector3d to_first = T_vehicle_town * first.T_town_vehicle()[0].translation();
  const Eigen::Vector3d to_second = T_vehicle_town * second.T_town_vehicle()[0].translation();
  EXPECT_NEAR(to_first.y(), 0.1, 0.01);
  EXPECT_NEAR(to_second.y(), -0.3, 0.01);
}

TEST_F(TownDrive, PosesAreRigidAndStandOnTheGround) {
  const DriveSimulator drive = simulator(options_of(0));
  for (const Pose& pose : drive.T_town_vehicle()) {
    ASSERT_TRUE(is_rigid(pose));
    ASSERT_NEAR(pose.translation().z(), 0.0, 0.12);
    ASSERT_GT(pose.linear()(2, 2), 0.999);
  }
}

TEST_F(TownDrive, DisturbedPosesAreOffByTwoCentimetresAndFourHundredthsOfADegree) {
  const DriveSimulator drive = simulator(options_of(0, 200.0));
  const std::vector<Pose> disturbed = drive.disturbed_poses();
  double squares_m2 = 0.0;
  double squares_rad2 = 0.0;
  double largest_step_m = 0.0;
  Eigen::Vector3d last_m = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < disturbed.size(); ++i) {
    const Pose off = drive.T_town_vehicle()[i].inverse() * disturbed[i];
    squares_m2 += off.translation().squaredNorm();
    squares_rad2 += std::pow(Eigen::AngleAxisd(off.linear()).angle(), 2);
    const Eigen::Vector3d shift_m =
        disturbed[i].translation() - drive.T_town_vehicle()[i].translation();
    if (i > 0) largest_step_m = std::max(largest_step_m, (shift_m - last_m).norm());
    last_m = shift_m;
  }
  const auto count = static_cast<double>(disturbed.size());
  EXPECT_NEAR(std::sqrt(squares_m2 / count), 0.02, 0.006);
  EXPECT_NEAR(std::sqrt(squares_rad2 / count), to_radians(0.04), to_radians(0.012));
  EXPECT_LT(largest_step_m, 0.03);  // it drifts and does not jump
}

TEST_F(TownDrive, ByHandTurnsSixtyDegreesBetweenTwoScansAtWalkingPace) {
  const DriveSimulator drive = simulator(carried_by_hand(options_of(0, 70.0)));
  ASSERT_EQ(drive.scan_count(), 101U);
  EXPECT_EQ(drive.stamp_ns(3), 1'500'000'000);
  int turns = 0;
  for (std::size_t i = 1; i < drive.scan_count(); ++i) {
    const Pose step = drive.T_town_vehicle()[i - 1].inverse() * drive.T_town_vehicle()[i];
    EXPECT_NEAR(step.translation().norm(), 0.7, 0.1);
    const double turn_deg = Eigen::AngleAxisd(step.linear()).angle() * 180.0 / std::numbers::pi;
    if (turn_deg > 30.0) {
      EXPECT_NEAR(turn_deg, 60.0, 12.0);  // the way turns as well
      ++turns;
    }
  }
  EXPECT_GT(turns, 10);
  EXPECT_LT(turns, 50);
}

TEST_F(TownDrive, IsHandedToPassesPointForPoint) {
  const DriveSimulator drive = simulator(options_of(0, 3.0));
  const Drive made = recorded(drive, "mapping", drive.disturbed_poses(), 2);
  ASSERT_EQ(made.scans.size(), 4U);
  ASSERT_TRUE(made.has_poses());
  EXPECT_TRUE(validate(made).has_value());
  const Scan scan = value_of(made.store->read(2));
  const TownScan expected = drive.scan(2);
  ASSERT_EQ(scan.points_m.size(), expected.points.size());
  EXPECT_EQ(scan.points_m[9], expected.points[9].position_m.cast<double>());
}

TEST_F(TownDrive, RefusesWhatMakesNoSense) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(DriveSimulator::make(*town_, options_of(0)));
  std::vector<std::function<void(DriveOptions&)>> changes = {
      [](DriveOptions& options) { options.spacing_m = 0.0; },
      [](DriveOptions& options) { options.length_m = 201.0; },
      [](DriveOptions& options) { options.range_sigma_m = -0.01; },
      [](DriveOptions& options) { options.lateral_m = kNan; },
      [](DriveOptions& options) { options.sensor.beam_elevations_deg.clear(); }};
  for (const double times : {0.0, 11.0, kNan}) {
    changes.emplace_back([=](DriveOptions& options) { options.traffic = times; });
  }
  for (const double share : {-0.1, 1.0, kNan}) {
    changes.emplace_back([=](DriveOptions& options) { options.missing_share = share; });
  }
  for (std::size_t i = 0; i < changes.size(); ++i) {
    DriveOptions options = options_of(0);
    changes[i](options);
    EXPECT_EQ(code_of(DriveSimulator::make(*town_, options)), ErrorCode::kBadArgument) << i;
  }
  EXPECT_FALSE(town_sensor(17).has_value());
}

}  // namespace
}  // namespace sightline::town
