#include "passes/map/choose_scans.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <numbers>

#include "passes/map/choose_sites.h"
#include "passes/map/remove_moving.h"
#include "passes/map/sharpness/measure_sharpness.h"
#include "tests/support/box_world.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

constexpr std::size_t kCount = 50;  // scans of a day, a metre apart
const TestBox kHouse{{20.0, 5.0, 0.0}, {28.0, 5.8, 7.0}};
const TestBox kCar{{22.0, 2.2, 0.0}, {26.0, 3.9, 1.5}};

struct Day {
  BoxWorld world = random_street(1);
  double beside_m = 0.0;
  bool is_back = false;  // driven the other way
};

Day with(const TestBox& box) {
  Day day;
  day.world.boxes.push_back(box);
  return day;
}

std::vector<Pose> way_of(const Day& day) {
  std::vector<Pose> way;
  for (std::size_t i = 0; i < kCount; ++i) {
    const auto s_m = static_cast<double>(i);
    way.push_back(day.is_back ? pose_at(kCount - s_m, day.beside_m, std::numbers::pi)
                              : pose_at(s_m, day.beside_m, 0.0));
  }
  return way;
}

TestDrive drive_on(const std::vector<Day>& days) {
  std::vector<TestDrive> all;
  for (const Day& day : days) all.push_back(drive_through(day.world, way_of(day), 1.0));
  return joined_days(all);
}

ReleasedPoses shipped(const TestDrive& all, std::size_t days) {
  Drive first = all.drive;
  first.scans.resize(days * kCount);
  Trajectory poses = all.truth;
  poses.poses.resize(days * kCount);
  return *release(first, poses);
}

Trajectory chosen(const TestDrive& all, std::size_t days, const ChooseScansOptions& options = {},
                  std::vector<std::string>* warnings = nullptr) {
  TestContext ctx(2);
  const Trajectory trajectory =
      value_of(choose_scans(ctx, options, all.drive, all.drive, all.truth, shipped(all, days)));
  if (warnings) *warnings = ctx.warnings;
  return trajectory;
}

std::size_t laid_on(const Trajectory& trajectory, std::size_t day) {
  const auto first = trajectory.poses.begin() + static_cast<std::ptrdiff_t>(day * kCount);
  return static_cast<std::size_t>(std::count_if(
      first, first + kCount, [](const TrajectoryPose& pose) { return pose.is_laid; }));
}

// All but the scans at the ends of what the earlier days passed, which nothing passed on.
constexpr std::size_t kFewLaid = 2;

TEST(ChooseScans, LeavesOutADayOnWhichNothingIsNew) {
  std::vector<std::string> warnings;
  const Trajectory trajectory = chosen(drive_on({{}, {}, {}, {}}), 3, {}, &warnings);
  for (std::size_t day = 0; day < 3; ++day) EXPECT_EQ(laid_on(trajectory, day), kCount) << day;
  EXPECT_LE(laid_on(trajectory, 3), kFewLaid);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings.front().find("of 50 scans of new drives show no change"), std::string::npos)
      << warnings.front();
}

TEST(ChooseScans, LaysWhatShowsAHouseThatIsNewOrGone) {
  EXPECT_EQ(laid_on(chosen(drive_on({{}, {}, {}, with(kHouse)}), 3), 3), kCount);
  EXPECT_EQ(laid_on(chosen(drive_on({with(kHouse), with(kHouse), with(kHouse), {}}), 3), 3),
            kCount);
  const std::size_t near =
      laid_on(chosen(drive_on({{}, {}, {}, with(kHouse)}), 3, {.reach_m = 10.0}), 3);
  EXPECT_GT(near, 10u);
  EXPECT_LT(near, 40u);
  // The map knows it since the third day.
  EXPECT_LE(laid_on(chosen(drive_on({{}, {}, with(kHouse), with(kHouse)}), 3), 3), kFewLaid);
}

TEST(ChooseScans, ParkedCarsAreNoChange) {
  EXPECT_LE(laid_on(chosen(drive_on({{}, {}, {}, with(kCar)}), 3), 3), kFewLaid);
  EXPECT_LE(laid_on(chosen(drive_on({with(kCar), with(kCar), with(kCar), {}}), 3), 3), kFewLaid);
}

// No ray went through where it stands now, but above the ground before it.
TEST(ChooseScans, LaysAHouseThatCameOverOpenGround) {
  Day open;
  std::erase_if(open.world.boxes, [](const TestBox& box) {
    return box.low_m.y() > 0.0 && box.high_m.x() > 10.0 && box.low_m.x() < 45.0;
  });
  Day built = open;
  built.world.boxes.push_back({{20.0, 9.0, 0.0}, {28.0, 14.0, 7.0}});
  EXPECT_EQ(laid_on(chosen(drive_on({open, open, open, built}), 3), 3), kCount);
  EXPECT_EQ(laid_on(chosen(drive_on({built, built, built, open}), 3), 3), kCount);
  EXPECT_LE(laid_on(chosen(drive_on({open, open, open, open}), 3), 3), kFewLaid);
}

TEST(ChooseScans, LaysWhatTooFewDrivesKnow) {
  EXPECT_EQ(laid_on(chosen(drive_on({{}, {}, {}}), 2), 2), kCount);
  EXPECT_LE(laid_on(chosen(drive_on({{}, {}, {}}), 2, {.known_drives = 2}), 2), kFewLaid);
  EXPECT_EQ(laid_on(chosen(drive_on({{}, {}, {}, {}}), 3, {.laid = LaidScans::kAll}), 3), kCount);
}

TEST(ChooseScans, LaysOtherLanesAndDirections) {
  Day back;
  back.is_back = true;
  EXPECT_EQ(laid_on(chosen(drive_on({{}, {}, {}, back}), 3), 3), kCount);
  Day beside;
  beside.beside_m = 3.0;
  EXPECT_EQ(laid_on(chosen(drive_on({{}, {}, {}, beside}), 3), 3), kCount);
  beside.beside_m = 1.0;
  EXPECT_LE(laid_on(chosen(drive_on({{}, {}, {}, beside}), 3), 3), kFewLaid);
}

TEST(ChooseScans, LaysWhatConfirmsNothing) {
  Day plain;
  plain.world.boxes.clear();
  EXPECT_EQ(laid_on(chosen(drive_on({plain, plain, plain, plain}), 3), 3), kCount);
}

TEST(ChooseScans, ReleasedScansStayAsTheyWere) {
  TestDrive all = drive_on({{}, {}, {}, {}, {}});
  const Trajectory first = chosen(all, 3);
  all.truth.poses = first.poses;
  const Trajectory second = chosen(all, 4);
  for (std::size_t day = 0; day < 4; ++day) {
    EXPECT_EQ(laid_on(second, day), laid_on(first, day)) << day;
  }
  // What was not laid knows nothing: of one laid day and one that was left out, one is known.
  TestDrive few = drive_on({{}, {}, {}});
  for (std::size_t i = kCount; i < 2 * kCount; ++i) few.truth.poses[i].is_laid = false;
  EXPECT_EQ(laid_on(chosen(few, 2, {.known_drives = 2}), 2), kCount);
}

TEST(ChooseScans, WhatIsNotLaidIsNotInTheMap) {
  TestDrive all = drive_on({{}, {}, {}});
  TestDrive some = all;
  for (std::size_t i = 2 * kCount; i < 3 * kCount; ++i) some.truth.poses[i].is_laid = false;
  TestDrive two = drive_on({{}, {}});
  PassContext ctx;
  const auto points_of = [&](const TestDrive& test) {
    return to_bytes(*remove_moving(ctx, {}, test.drive, test.truth));
  };
  EXPECT_EQ(points_of(some), points_of(two));
  EXPECT_NE(points_of(some), points_of(all));
  const auto sharpness_of = [&](const TestDrive& test) {
    return to_bytes(*measure_sharpness(ctx, {}, test.drive, test.truth));
  };
  EXPECT_EQ(sharpness_of(some), sharpness_of(two));
  EXPECT_NE(sharpness_of(some), sharpness_of(all));
  for (std::size_t i = 2 * kCount; i < 3 * kCount; ++i) {
    all.truth.poses[i].T_map_vehicle.translation().y() += 3.0;
    some.truth.poses[i].T_map_vehicle.translation().y() += 3.0;
  }
  const auto sites_of = [&](const TestDrive& test) {
    return choose_sites(ctx, {}, test.drive, test.truth)->sites.size();
  };
  EXPECT_EQ(sites_of(some), sites_of(two));
  EXPECT_GT(sites_of(all), sites_of(two));
}

TEST(ChooseScans, RefusesATrajectoryOfAnotherDrive) {
  const TestDrive all = drive_on({{}, {}});
  Trajectory other = all.truth;
  other.poses.pop_back();
  EXPECT_EQ(
      failure_of(choose_scans(TestContext(), {}, all.drive, all.drive, other, shipped(all, 1)))
          .code,
      ErrorCode::kMismatchedInputs);
}

TEST(ChooseScans, ThreadsDoNotDecide) {
  const TestDrive all = drive_on({{}, {}, {}, with(kHouse)});
  const Trajectory two = chosen(all, 3, {.reach_m = 12.0});
  const Result<Trajectory> one = choose_scans(TestContext(), {.reach_m = 12.0}, all.drive,
                                              all.drive, all.truth, shipped(all, 3));
  EXPECT_EQ(to_bytes(*one), to_bytes(two));
}

}  // namespace
}  // namespace sightline
