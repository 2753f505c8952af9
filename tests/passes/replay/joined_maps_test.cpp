#include "passes/replay/joined_maps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/base/files/atomic_file.h"
#include "formats/map/map_writer.h"
#include "tests/formats/map/random_map.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

using ::testing::HasSubstr;

constexpr double kReach_m = 10.0;

class JoinedMapsTest : public TestInFolder {
 protected:
  // Sites 1 m apart along x from that place on.
  std::string map_from(int first_x_m, const std::string& world = "utm:32N") {
    CompiledMap map = random_map({.site_count = 20, .run_count = 1, .looks = {}});
    map.world = world;
    map.reach_m = kReach_m;
    int x_m = first_x_m;
    for (Site& site : map.sites.sites) site.p_map_m = Eigen::Vector3d(x_m++, 0.0, 0.0);
    origin_world_m_ = map.ndt.frame.origin_world_m;
    const std::string file = (folder_ / ("from_" + std::to_string(first_x_m) + world)).string();
    EXPECT_TRUE(write_file_atomically(file + ".slmap", encode_map(map), IfExists::kReplace));
    return file + ".slmap";
  }
  Eigen::Vector3d at(double x_m) const { return origin_world_m_ + Eigen::Vector3d(x_m, 0.0, 0.0); }

 private:
  Eigen::Vector3d origin_world_m_ = Eigen::Vector3d::Zero();
};

std::size_t map_at(JoinedMaps& maps, const Eigen::Vector3d& sensor_world_m, bool is_tracking) {
  EXPECT_TRUE(maps.go_to(sensor_world_m, is_tracking));
  return maps.present();
}

// Sites of the first map are at 0 to 19 m, of the second at 15 to 34 m.
TEST_F(JoinedMapsTest, KeepsThePresentMapToItsReachWhileTracking) {
  JoinedMaps maps = value_of(JoinedMaps::open({map_from(0), map_from(15)}, {}));
  EXPECT_EQ(map_at(maps, at(5.0), true), 0U);
  EXPECT_EQ(map_at(maps, at(28.9), true), 0U);
  EXPECT_EQ(map_at(maps, at(29.1), true), 1U);
  EXPECT_EQ(map_at(maps, at(16.0), true), 1U) << "back again";
  EXPECT_EQ(map_at(maps, at(4.9), true), 0U);
}

TEST_F(JoinedMapsTest, TakesTheMapOfTheNearestSiteForAVehicleThatDoesNotTrack) {
  JoinedMaps maps = value_of(JoinedMaps::open({map_from(0), map_from(15), map_from(60)}, {}));
  EXPECT_EQ(map_at(maps, at(24.0), false), 1U);
  EXPECT_EQ(map_at(maps, at(10.0), false), 0U);
  EXPECT_EQ(map_at(maps, at(55.0), false), 2U);
  EXPECT_EQ(map_at(maps, at(500.0), false), 2U) << "no map is there";
}

TEST_F(JoinedMapsTest, GoesOnWithoutAMapThatIsMissing) {
  const std::string missing = (folder_ / "missing.slmap").string();
  JoinedMaps maps = value_of(JoinedMaps::open({missing, map_from(0)}, {}));
  ASSERT_TRUE(maps.fault(0));
  EXPECT_EQ(maps.fault(0)->code, ErrorCode::kFileNotFound);
  EXPECT_EQ(map_at(maps, at(5.0), false), 1U);
}

// Damage is found when a map is opened or read whole, or when its sites are searched.
TEST_F(JoinedMapsTest, GoesOnWithoutAMapThatIsDamaged) {
  const std::string good = map_from(0);
  const std::string damaged = map_from(15);
  const std::string bytes = value_of(read_text_file(damaged));
  int damaged_count = 0;
  for (std::size_t byte = 130; byte < bytes.size(); byte += bytes.size() / 23) {
    std::string changed = bytes;
    changed[byte] ^= 1;
    ASSERT_TRUE(write_file_atomically(damaged, changed, IfExists::kReplace));
    JoinedMaps maps = value_of(JoinedMaps::open({good, damaged}, {}));
    EXPECT_EQ(map_at(maps, at(5.0), true), 0U);
    const std::size_t there = map_at(maps, at(30.0), true);
    EXPECT_EQ(there, maps.fault(1) ? 0U : 1U) << byte;
    if (!maps.fault(1)) continue;
    ++damaged_count;
    EXPECT_THAT(to_string(*maps.fault(1)), HasSubstr(damaged));
  }
  EXPECT_GT(damaged_count, 15) << "the other bytes are padding";
}

TEST_F(JoinedMapsTest, FailsWithTheFirstFaultWhereNoMapIsLeft) {
  const Result<JoinedMaps> none =
      JoinedMaps::open({(folder_ / "one.slmap").string(), (folder_ / "two.slmap").string()}, {});
  ASSERT_FALSE(none);
  EXPECT_THAT(to_string(none.error()), HasSubstr("one.slmap"));
}

TEST_F(JoinedMapsTest, AreOfOneWorldThatHasAName) {
  for (const std::string world : {"utm:33N", "local"}) {
    const Result<JoinedMaps> maps = JoinedMaps::open({map_from(0), map_from(15, world)}, {});
    ASSERT_FALSE(maps) << world;
    EXPECT_EQ(maps.error().code, ErrorCode::kMismatchedInputs);
    EXPECT_THAT(maps.error().message, HasSubstr("utm:32N"));
    EXPECT_THAT(maps.error().message, HasSubstr(world));
    EXPECT_THAT(maps.error().message, HasSubstr("annotation.world"));
  }
  EXPECT_FALSE(JoinedMaps::open({map_from(0, "local"), map_from(15, "local")}, {}));
  EXPECT_TRUE(JoinedMaps::open({map_from(0, "local")}, {})) << "one map needs none";
}

}  // namespace
}  // namespace sightline
