#include "passes/map/moving_verdict.h"

#include <gtest/gtest.h>
#include <vector>

#include "formats/base/random.h"
#include "passes/map/seen_voxels.h"

namespace sightline {
namespace {

constexpr double kVoxel_m = 0.2;
// Half the edge of the ground, in voxels: several places that tell the level of ground.
constexpr std::int32_t kReach = 30;
constexpr std::uint32_t kStood = 8;
constexpr std::uint32_t kPassed = 12;

void put(SeenVoxels& seen, const CellKey& key, std::uint32_t hits, std::uint32_t misses) {
  SeenVoxel voxel;
  voxel.sum_m = kVoxel_m * (Eigen::Vector3d(key.x, key.y, key.z) + Eigen::Vector3d::Constant(0.5));
  voxel.point_count = 1;
  voxel.hits = hits;
  voxel.misses = misses;
  seen.insert(key, voxel);
}

void put_level(SeenVoxels& seen, std::int32_t z, std::uint32_t hits, std::uint32_t misses) {
  for (std::int32_t x = 0; x < 6; ++x) {
    for (std::int32_t y = 0; y < 6; ++y) put(seen, {x, y, z}, hits, misses);
  }
}

// Ground that every scan hits, its returns 0.1 m above z = 0, or other levels on its two sides.
SeenVoxels ground(std::int32_t below_0 = 0, std::int32_t from_0 = 0) {
  SeenVoxels seen;
  for (std::int32_t x = -kReach; x < kReach; ++x) {
    for (std::int32_t y = -kReach; y < kReach; ++y) {
      put(seen, {x, y, x < 0 ? below_0 : from_0}, kStood, 0);
    }
  }
  return seen;
}

void put_moved(SeenVoxels& seen, const CellKey& at, std::int32_t low, std::int32_t high) {
  for (std::int32_t z = low; z < high; ++z) put(seen, {at.x, at.y, z}, 1, kPassed);
}

std::vector<std::uint8_t> judged(SeenVoxels& seen) {
  mark_ground(seen);
  return judge(seen);
}

bool has_moved(SeenVoxels& seen, const CellKey& key) {
  return judged(seen)[seen.number_of(key)] == 1;
}

TEST(MovingVerdict, LeavesWhatHangsInTheAirAndTakesTheSameThingLowDown) {
  for (const std::int32_t z : {3, 6, 9}) {
    SeenVoxels seen = ground();
    put_moved(seen, {2, 3, 0}, z, z + 1);
    EXPECT_TRUE(has_moved(seen, {2, 3, z})) << z;
  }
  for (const std::int32_t z : {12, 15, 20}) {
    SeenVoxels seen = ground();
    put_moved(seen, {2, 3, 0}, z, z + 1);
    EXPECT_FALSE(has_moved(seen, {2, 3, z})) << z;
  }
}

// A lorry 3.8 m high, closed and with free space of 0.8 m below.
TEST(MovingVerdict, TakesWhatIsHighWhereSomethingMovedInEveryBandBelow) {
  for (const std::int32_t low : {1, 5}) {
    SeenVoxels seen = ground();
    put_moved(seen, {0, 0, 0}, low, 20);
    const std::vector<std::uint8_t> moved = judged(seen);
    for (std::int32_t z = low; z < 20; ++z) EXPECT_EQ(moved[seen.number_of({0, 0, z})], 1) << z;
  }
}

// A wire above a car: nothing moved between them.
TEST(MovingVerdict, LeavesWhatIsHighWhereABandBelowIsEmpty) {
  SeenVoxels seen = ground();
  put_moved(seen, {0, 0, 0}, 1, 8);
  put_moved(seen, {0, 0, 0}, 16, 18);
  const std::vector<std::uint8_t> moved = judged(seen);
  EXPECT_EQ(moved[seen.number_of({0, 0, 7})], 1);
  EXPECT_EQ(moved[seen.number_of({0, 0, 16})], 0);
  EXPECT_EQ(moved[seen.number_of({0, 0, 17})], 0);
}

TEST(MovingVerdict, TakesNothingAboveTheTallestTraffic) {
  SeenVoxels seen = ground();
  put_moved(seen, {0, 0, 0}, 1, 30);
  const std::vector<std::uint8_t> moved = judged(seen);
  for (std::int32_t z = 1; z < 30; ++z) {
    EXPECT_EQ(moved[seen.number_of({0, 0, z})] == 1, kVoxel_m * z <= 4.5) << z;
  }
}

// Footing at any place and from any height: what begins above 1.5 m stays above 2 m.
TEST(MovingVerdict, NeedsFootingWhereverItIs) {
  Random random(7);
  for (int i = 0; i < 10; ++i) {
    const CellKey at{static_cast<std::int32_t>(random.next() % 40) - 20,
                     static_cast<std::int32_t>(random.next() % 40) - 20, 0};
    const auto low = 8 + static_cast<std::int32_t>(random.next() % 6);
    SeenVoxels seen = ground();
    put_moved(seen, at, low, 22);
    const std::vector<std::uint8_t> moved = judged(seen);
    for (std::int32_t z = std::max(low, 11); z < 22; ++z) {
      EXPECT_EQ(moved[seen.number_of({at.x, at.y, z})], 0) << at.x << " " << at.y << " " << z;
    }
  }
}

// Wet ground: some rays come back from below it, each seen through as often as real ground hides
// it.
TEST(MovingVerdict, TellsGroundAboveItsMirrorImage) {
  SeenVoxels seen = ground();
  put_level(seen, -9, 2, 0);
  mark_ground(seen);
  for (std::int32_t x = -3; x < 9; ++x) {
    for (std::int32_t y = -3; y < 9; ++y) {
      const SeenVoxel& above = *seen.find({x, y, 0});
      EXPECT_TRUE(above.is_ground) << x << " " << y;
      EXPECT_NEAR(above.above_ground_m, 0.0, 0.01);
    }
  }
  for (std::int32_t x = 0; x < 6; ++x) {
    const SeenVoxel& mirrored = *seen.find({x, 2, -9});
    EXPECT_FALSE(mirrored.is_ground);
    EXPECT_NEAR(mirrored.above_ground_m, -1.8, 0.01);
  }
}

TEST(MovingVerdict, IsTheSameOverMirroredGround) {
  SeenVoxels dry = ground();
  put_moved(dry, {2, 2, 0}, 1, 9);
  put_moved(dry, {3, 3, 0}, 15, 17);
  SeenVoxels wet = dry;
  put_level(wet, -9, 2, 0);
  const std::vector<std::uint8_t> moved_dry = judged(dry);
  const std::vector<std::uint8_t> moved_wet = judged(wet);
  for (std::size_t v = 0; v < dry.size(); ++v) EXPECT_EQ(moved_dry[v], moved_wet[v]) << v;
  EXPECT_EQ(moved_wet[wet.number_of({2, 2, 3})], 1);
  EXPECT_EQ(moved_wet[wet.number_of({3, 3, 15})], 0);
}

// A walker below a tree: single voxels of leaves that are looked through, one in each band.
TEST(MovingVerdict, LeavesWhatIsHighWhereABandBelowHasASingleVoxel) {
  SeenVoxels seen = ground();
  put_moved(seen, {0, 0, 0}, 1, 10);
  for (const std::int32_t z : {11, 13, 16}) put_moved(seen, {0, 0, 0}, z, z + 1);
  const std::vector<std::uint8_t> moved = judged(seen);
  EXPECT_EQ(moved[seen.number_of({0, 0, 9})], 1);
  EXPECT_EQ(moved[seen.number_of({0, 0, 13})], 0);
  EXPECT_EQ(moved[seen.number_of({0, 0, 16})], 0);
}

// A pavement 0.2 m above the street, its edge near.
TEST(MovingVerdict, TakesAPavementForGroundWhereNothingStandsOnIt) {
  SeenVoxels seen = ground(0, 1);
  for (std::int32_t z = 3; z < 8; ++z) put(seen, {2, 20, z}, 1, kPassed);
  mark_ground(seen);
  EXPECT_TRUE(seen.find({2, 0, 1})->is_ground);
  EXPECT_TRUE(seen.find({2, 0, 1})->is_level);
  EXPECT_FALSE(seen.find({2, 20, 1})->is_ground);
  // Neither what lies higher, nor a single thing on the street.
  SeenVoxels low = ground();
  put_level(low, 4, 1, kPassed);
  put(low, {20, 20, 1}, 1, kPassed);
  put(low, {20, 20, 2}, 1, kPassed);
  mark_ground(low);
  EXPECT_FALSE(low.find({3, 3, 4})->is_ground);
  EXPECT_FALSE(low.find({20, 20, 2})->is_ground);
}

// Grass: rays pass below some of it.
TEST(MovingVerdict, TakesLevelGroundOnlyWhereMuchContradictsIt) {
  for (const auto& [misses, has_gone] : {std::pair{4u, false}, {6u, true}}) {
    SeenVoxels seen = ground();
    SeenVoxel& voxel = seen.values()[seen.number_of({3, 3, 0})];
    voxel.hits = 1;
    voxel.misses = misses;
    EXPECT_EQ(has_moved(seen, {3, 3, 0}), has_gone) << misses;
  }
  SeenVoxels apart = ground();
  put(apart, {3 + kReach, 0, 0}, 1, 4);
  EXPECT_TRUE(has_moved(apart, {3 + kReach, 0, 0}));
}

// A cutting, a basement ramp: what most of the surroundings share lower down is ground.
TEST(MovingVerdict, TakesAWideLowerLevelForGround) {
  SeenVoxels seen = ground(-9, 0);
  mark_ground(seen);
  EXPECT_TRUE(seen.find({-20, 5, -9})->is_ground);
  EXPECT_TRUE(seen.find({20, 5, 0})->is_ground);
}

}  // namespace
}  // namespace sightline
