#include "passes/ingest/join_drives.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/base/random.h"
#include "formats/base/units.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

using testing::HasSubstr;

constexpr std::int64_t kMonday_ns = 1'700'000'000 * kSecond_ns;
constexpr std::int64_t kDay_ns = 86'400 * kSecond_ns;

// A drive whose scan k, one a second from `begin_ns` on, holds the one point (k, x, 0).
Drive day(const std::string& name, std::int64_t begin_ns, int count, double x) {
  Drive drive;
  drive.name = name;
  drive.sensor.beam_elevations_deg = {-1.0, 1.0};
  std::vector<Scan> scans;
  for (int k = 0; k < count; ++k) {
    ScanInfo& info = drive.scans.emplace_back();
    info.recording_index = static_cast<std::uint32_t>(k);
    info.stamp_ns = begin_ns + k * kSecond_ns;
    info.point_count = 1;
    scans.push_back({info.stamp_ns, {Eigen::Vector3d(k, x, 0.0)}});
  }
  return with_store(drive, memory_scan_store(std::move(scans)));
}

struct Joined {
  Drive drive;
  std::vector<std::string> warnings;
};

Joined join(const Drive& first, const Drive& later) {
  TestContext ctx;
  Drive drive = value_of(join_drives(ctx, {}, first, {{&later}}));
  EXPECT_TRUE(validate(drive).has_value());
  return {std::move(drive), ctx.warnings};
}

TEST(JoinDrives, PutsOneBehindTheOtherAndKeepsWhatIsEven) {
  const Joined joined =
      join(day("monday", kMonday_ns, 3, 1.0), day("tuesday", kMonday_ns + kDay_ns, 2, 2.0));
  EXPECT_TRUE(joined.warnings.empty());
  EXPECT_EQ(joined.drive.name, "monday");
  EXPECT_EQ(joined.drive.later_parts, std::vector<std::string>{"tuesday"});
  EXPECT_EQ(joined.drive.names_of_parts(), "monday, tuesday");
  ASSERT_EQ(joined.drive.scans.size(), 5U);
  const std::vector<std::uint32_t> indices = {0, 1, 2, 4, 5};
  for (std::size_t i = 0; i < 5; ++i) {
    const bool is_later = i >= 3;
    const ScanInfo& scan = joined.drive.scans[i];
    EXPECT_EQ(scan.recording_index, indices[i]);
    EXPECT_EQ(scan.part, is_later ? 1U : 0U);
    EXPECT_EQ(joined.drive.name_of_part(scan.part), is_later ? "tuesday" : "monday");
    const Result<Scan> read = joined.drive.store->read(i);
    EXPECT_EQ(read->points_m.at(0),
              Eigen::Vector3d(is_later ? static_cast<double>(i - 3) : static_cast<double>(i),
                              is_later ? 2.0 : 1.0, 0.0));
    EXPECT_EQ(read->stamp_ns, scan.stamp_ns);
  }
  EXPECT_EQ(joined.drive.scans[3].stamp_ns, kMonday_ns + kDay_ns) << "true times stay";
}

TEST(JoinDrives, KeepsTheTurnRatesOfEachPartAndMovesThemWithIt) {
  Drive first = day("a", 0, 3, 1.0);
  Drive later = day("b", 0, 3, 2.0);
  later.turn_rates = {{-5, Eigen::Vector3d(1, 2, 3)}, {kSecond_ns, Eigen::Vector3d(4, 5, 6)}};
  const Joined one = join(first, later);
  const std::int64_t later_ns = one.drive.scans[3].stamp_ns;
  ASSERT_EQ(one.drive.turn_rates.size(), 2U);
  EXPECT_EQ(one.drive.turn_rates[0].stamp_ns, later_ns - 5);
  EXPECT_EQ(one.drive.turn_rates[1].stamp_ns, later_ns + kSecond_ns);
  EXPECT_EQ(one.drive.turn_rates[1].rate_rad_per_s, Eigen::Vector3d(4, 5, 6));
  first.turn_rates = {{3 * kSecond_ns, Eigen::Vector3d(7, 8, 9)}};
  const Joined both = join(first, later);
  ASSERT_EQ(both.drive.turn_rates.size(), 3U);
  EXPECT_EQ(both.drive.turn_rates[0].stamp_ns, 3 * kSecond_ns);
}

TEST(JoinDrives, MovesTimesThatOverlapAndSaysSoOfAClock) {
  const Joined counted = join(day("a", 0, 3, 1.0), day("b", 0, 3, 2.0));
  EXPECT_TRUE(counted.warnings.empty()) << "times from 0 on are no clock's";
  EXPECT_EQ(counted.drive.scans[3].stamp_ns, 2 * kSecond_ns + kPauseBetweenParts_ns);
  EXPECT_EQ(counted.drive.scans[4].stamp_ns, 3 * kSecond_ns + kPauseBetweenParts_ns);
  EXPECT_EQ(counted.drive.store->read(4)->stamp_ns, counted.drive.scans[4].stamp_ns);

  const Joined wrong =
      join(day("monday", kMonday_ns, 3, 1.0), day("tuesday", kMonday_ns - 3600 * kSecond_ns, 3, 2));
  ASSERT_EQ(wrong.warnings.size(), 1U);
  EXPECT_THAT(wrong.warnings[0], HasSubstr("drive tuesday begins at"));
  EXPECT_THAT(wrong.warnings[0], HasSubstr("moved by 3662"));
}

TEST(JoinDrives, LeavesOutADriveOfAnotherSensorByName) {
  const Drive first = day("monday", 0, 3, 1.0);
  Drive other = day("tuesday", 0, 3, 2.0);
  other.sensor.name = "hdl-64e";
  const Joined joined = join(first, other);
  EXPECT_EQ(joined.drive.scans.size(), 3U);
  ASSERT_EQ(joined.warnings.size(), 1U);
  EXPECT_THAT(joined.warnings[0], HasSubstr("drive tuesday is left out: its sensor is hdl-64e"));
  Drive moved = day("tuesday", 0, 3, 2.0);
  moved.sensor.T_vehicle_lidar.translation().x() = 1.0;
  EXPECT_EQ(join(first, moved).drive.scans.size(), 3U);
}

TEST(JoinDrives, TakesTheFrameOfTheFirstThatHasPoses) {
  Drive with_poses = day("tuesday", 0, 2, 2.0);
  with_poses.frame.origin_world_m = Eigen::Vector3d(100.0, 200.0, 0.0);
  for (ScanInfo& scan : with_poses.scans) scan.T_world_vehicle = Pose::Identity();
  EXPECT_EQ(join(day("monday", 0, 2, 1.0), with_poses).drive.frame.origin_world_m.x(), 100.0);
  Drive first = with_poses;
  first.frame.origin_world_m.x() = 7.0;
  EXPECT_EQ(join(first, with_poses).drive.frame.origin_world_m.x(), 7.0);
}

TEST(JoinDrives, ChainsOfRandomDrivesAreDrivesThatSurviveAFile) {
  Random random(7);
  for (int round = 0; round < 50; ++round) {
    const Drive first = day("0", static_cast<std::int64_t>(random.below(1000)) * kSecond_ns,
                            1 + static_cast<int>(random.below(5)), 0.0);
    Drive all = first;
    std::vector<Drive> others;
    std::size_t scans = all.scans.size();
    for (int later = 1; later < 4; ++later) {
      const Drive next =
          day(std::to_string(later), static_cast<std::int64_t>(random.below(1000)) * kSecond_ns,
              static_cast<int>(random.below(5)), later);
      scans += next.scans.size();
      all = join(all, next).drive;
      others.push_back(next);
    }
    ASSERT_EQ(all.scans.size(), scans);
    const Drive at_once =
        value_of(join_drives(TestContext(), {}, first, {{&others[0], &others[1], &others[2]}}));
    ASSERT_EQ(to_bytes(at_once), to_bytes(all));
    const Drive back = value_of(from_bytes<Drive>(to_bytes(all)));
    ASSERT_EQ(to_bytes(back), to_bytes(all));
    for (std::size_t i = 0; i < scans; ++i) {
      const Result<Scan> scan = all.store->read(i);
      ASSERT_EQ(std::to_string(static_cast<int>(scan->points_m[0].y())),
                all.name_of_part(all.scans[i].part).substr(0, 1));
    }
  }
}

}  // namespace
}  // namespace sightline
