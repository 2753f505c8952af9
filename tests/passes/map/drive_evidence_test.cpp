#include "passes/map/drive_evidence.h"

#include <gtest/gtest.h>

#include "passes/map/moving_verdict.h"
#include "passes/map/remove_moving.h"
#include "tests/support/box_world.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

struct OfDrive {
  int hits = 0;
  int misses = 0;
};

// What is concluded of one voxel, 1.5 m above the ground.
SeenVoxel concluded(const std::vector<OfDrive>& drives) {
  SeenVoxels seen;
  SeenVoxel voxel;
  voxel.above_ground_m = 1.5F;
  voxel.point_count = 1;
  seen.insert({0, 0, 0}, voxel);
  DriveEvidence evidence(drives.size());
  // Counts of every drive, also where it saw nothing.
  for (std::size_t drive = 0; drive < drives.size(); ++drive) {
    for (int i = 0; i < drives[drive].hits; ++i) evidence.add_hit(0, drive);
    for (int i = 0; i < drives[drive].misses; ++i) evidence.add_miss(0, drive);
  }
  evidence.conclude(seen);
  return seen.values()[0];
}

TEST(DriveEvidence, OfOneDriveIsItsOwn) {
  EXPECT_NEAR(log_odds(concluded({{2, 1}, {0, 0}})), log_odds(2, 1), 1e-12);
  EXPECT_EQ(log_odds(concluded({{100, 0}, {0, 0}})), kStrongLogOdds);
}

TEST(DriveEvidence, WhatTheLatestSeesThroughIsGone) {
  const SeenVoxel house = concluded({{100, 0}, {100, 0}, {0, 20}, {0, 20}});
  EXPECT_LT(log_odds(house), 0.0);
  EXPECT_TRUE(house.has_changed);
  const SeenVoxel stays = concluded({{100, 0}, {100, 0}, {50, 20}});
  EXPECT_GT(log_odds(stays), 0.0);
  EXPECT_FALSE(stays.has_changed);
}

TEST(DriveEvidence, WhatWasParkedOnOneOfThreeDaysIsGoneWhicheverDayThatWas) {
  for (std::size_t day = 0; day < 3; ++day) {
    std::vector<OfDrive> drives(3, {0, 30});
    drives[day] = {40, 0};
    EXPECT_LT(log_odds(concluded(drives)), 0.0) << day;
  }
  // One day against one says nothing of which is usual: the later one is right.
  EXPECT_GT(log_odds(concluded({{0, 30}, {40, 0}})), 0.0);
  EXPECT_LT(log_odds(concluded({{40, 0}, {0, 30}})), 0.0);
}

// What the third drive says of a voxel that two knew, above another in the same column.
DriveEvidence::Comparison compared(const std::vector<OfDrive>& drives, float above_m,
                                   const std::vector<OfDrive>& below) {
  SeenVoxels seen;
  SeenVoxel voxel;
  voxel.above_ground_m = above_m;
  voxel.point_count = 1;
  seen.insert({0, 0, 20}, voxel);
  voxel.above_ground_m = 1.0F;
  for (int i = 0; i < 4; ++i) seen.insert({i % 2, i / 2, 5}, voxel);
  DriveEvidence evidence(3);
  for (std::uint32_t v = 0; v < 5; ++v) {
    const std::vector<OfDrive>& said = v == 0 ? drives : below;
    for (std::size_t drive = 0; drive < said.size(); ++drive) {
      for (int i = 0; i < said[drive].hits; ++i) evidence.add_hit(v, drive);
      for (int i = 0; i < said[drive].misses; ++i) evidence.add_miss(v, drive);
    }
  }
  return evidence.compare(seen, 2).front();
}

TEST(DriveEvidence, ComparesWhatStoodWithWhatStands) {
  using enum DriveEvidence::Comparison;
  const std::vector<OfDrive> nothing(3);
  const OfDrive hit{5, 0};
  const OfDrive missed{0, 8};
  EXPECT_EQ(compared({hit, hit, hit}, 4.0F, nothing), kConfirmed);
  EXPECT_EQ(compared({hit, hit, missed}, 4.0F, nothing), kChanged);
  EXPECT_EQ(compared({missed, missed, hit}, 4.0F, nothing), kChanged);
  EXPECT_EQ(compared({missed, missed, missed}, 4.0F, nothing), kNothing);
  EXPECT_EQ(compared({hit, hit, missed}, 1.9F, nothing), kNothing) << "where cars are parked";
  // The second drive had seen it go, or come.
  EXPECT_EQ(compared({hit, missed, missed}, 4.0F, nothing), kNothing);
  EXPECT_EQ(compared({missed, hit, hit}, 4.0F, nothing), kConfirmed);
  // Weak evidence on either side.
  EXPECT_EQ(compared({hit, hit, {0, 1}}, 4.0F, nothing), kNothing);
  EXPECT_EQ(compared({{1, 0}, {}, missed}, 4.0F, nothing), kNothing);
}

TEST(DriveEvidence, WhatOneSideDoesNotKnowIsDecidedBelow) {
  using enum DriveEvidence::Comparison;
  const std::vector<OfDrive> nothing(3);
  const OfDrive hit{5, 0};
  const OfDrive missed{0, 8};
  const std::vector<OfDrive> went = {hit, hit, missed};
  const std::vector<OfDrive> came = {missed, missed, hit};
  EXPECT_EQ(compared({hit, hit, {}}, 4.0F, nothing), kNothing);
  EXPECT_EQ(compared({hit, hit, {}}, 4.0F, went), kChanged);
  EXPECT_EQ(compared({hit, hit, {}}, 4.0F, came), kNothing);
  EXPECT_EQ(compared({{}, {}, hit}, 4.0F, came), kChanged);
  EXPECT_EQ(compared({{}, {}, hit}, 4.0F, went), kNothing);
}

TEST(DriveEvidence, StandsAnywayOnlyWhereNoDriveCouldContradict) {
  DriveEvidence evidence(2);
  for (int i = 0; i < 20; ++i) evidence.add_hit(0, 0);
  EXPECT_TRUE(evidence.stands_anyway(0, {20, 0}));
  EXPECT_FALSE(evidence.stands_anyway(0, {20, 5})) << "the other drive may look through it";
  for (int i = 0; i < 10; ++i) evidence.add_hit(0, 1);
  EXPECT_TRUE(evidence.stands_anyway(0, {20, 5}));
}

// Days of standing scans in one street; `add` puts what is there that day.
template <class Add>
SurfacePoints days_in_street(std::size_t days, const Add& add) {
  std::vector<Pose> poses;
  for (int i = 0; i < 12; ++i) poses.push_back(pose_at(i, 0.0, 0.0));
  std::vector<TestDrive> drives;
  for (std::size_t day = 0; day < days; ++day) {
    BoxWorld world = random_street(1);
    add(day, world);
    drives.push_back(drive_through(world, poses, 0.5));
  }
  const TestDrive test = joined_days(drives);
  return value_of(remove_moving(TestContext(), {}, test.drive, test.truth));
}

std::size_t standing_in(const SurfacePoints& points, const TestBox& box) {
  const SurfacePointReader reader(points);
  std::size_t count = 0;
  for (std::size_t part = 0; part < reader.part_count(); ++part) {
    const std::vector<Eigen::Vector3d> standing_m = value_of(reader.standing(part));
    for (const Eigen::Vector3d& p_m : standing_m) {
      count +=
          ((p_m - box.low_m).array() >= -0.01).all() && ((box.high_m - p_m).array() >= -0.01).all()
              ? 1
              : 0;
    }
  }
  return count;
}

constexpr double kNoGround_m = 0.3;  // a car's lowest part may be taken for ground

TEST(RemoveMovingOfDrives, TakesACarThatWasParkedOnOneDayOfThree) {
  const TestBox car{{4.0, 2.2, 0.0}, {8.0, 3.9, 1.5}};
  TestBox above = car;
  above.low_m.z() = kNoGround_m;
  for (std::size_t parked = 0; parked < 3; ++parked) {
    const auto on = [&](std::size_t first, std::size_t last) {
      return standing_in(days_in_street(3,
                                        [&](std::size_t day, BoxWorld& world) {
                                          if (day >= first && day <= last) {
                                            world.boxes.push_back(car);
                                          }
                                        }),
                         above);
    };
    const std::size_t always = on(0, 2);
    ASSERT_GT(always, 500u);
    EXPECT_LT(on(parked, parked), always / 50) << "day " << parked;
  }
}

TEST(RemoveMovingOfDrives, KeepsTheHouseThatWasBuiltAndDropsTheOneThatIsGone) {
  const TestBox old_house{{2.0, 5.0, 0.0}, {10.0, 5.8, 7.0}};
  const TestBox new_house{{2.0, -4.6, 0.0}, {10.0, -4.0, 7.0}};
  const SurfacePoints points = days_in_street(3, [&](std::size_t day, BoxWorld& world) {
    world.boxes.push_back(day < 2 ? old_house : new_house);
  });
  TestBox gone = old_house;
  TestBox built = new_house;
  gone.low_m.z() = built.low_m.z() = 0.5;
  const SurfacePoints only_new =
      days_in_street(1, [&](std::size_t, BoxWorld& world) { world.boxes.push_back(new_house); });
  const SurfacePoints only_old =
      days_in_street(1, [&](std::size_t, BoxWorld& world) { world.boxes.push_back(old_house); });
  EXPECT_GT(standing_in(points, built), 9 * standing_in(only_new, built) / 10);
  EXPECT_LT(standing_in(points, gone), standing_in(only_old, gone) / 10);
}

}  // namespace
}  // namespace sightline
