#include "passes/trajectory/graph/check_poses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cmath>
#include <set>

#include "passes/trajectory/estimate_trajectory.h"
#include "tests/support/box_world.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// Two pieces, the second along the first: scan i of it beside scan i of the other.
constexpr std::uint32_t kCount = 12;

struct TwoPieces {
  Odometry odometry;
  std::vector<Pose> T_map_lidar;
  std::vector<GraphEdge> loops;

  TwoPieces() {
    for (std::uint32_t i = 0; i < 2 * kCount; ++i) {
      odometry.piece.push_back(i / kCount);
      T_map_lidar.push_back(pose_at(5.0 * (i % kCount), i < kCount ? 0.0 : 1.0, 0.0));
    }
    for (std::uint32_t i = 0; i < kCount; ++i) {
      loops.push_back({i, kCount + i, T_map_lidar[i].inverse() * T_map_lidar[kCount + i]});
    }
  }
  void put_off(std::uint32_t loop, double off_m) {
    loops[loop].T_from_to.translation().x() += off_m;
  }
  [[nodiscard]] std::vector<Contradiction> found() const {
    return find_contradictions(odometry, loops, T_map_lidar);
  }
};

TEST(Contradictions, AreNoneWhereLoopsAreMet) {
  TwoPieces pieces;
  for (std::uint32_t i = 0; i < kCount; ++i) pieces.put_off(i, 0.2);
  EXPECT_TRUE(pieces.found().empty());
}

TEST(Contradictions, AreNotMadeByAFalseLoopAmongTrueOnes) {
  TwoPieces pieces;
  pieces.put_off(2, 3.0);
  pieces.put_off(3, 3.0);
  pieces.put_off(9, 3.0);
  EXPECT_TRUE(pieces.found().empty());
}

TEST(Contradictions, AreFoundWhereHalfOfSixLoopsAreOff) {
  TwoPieces pieces;
  pieces.put_off(6, 0.5);
  pieces.put_off(8, -0.75);
  pieces.put_off(10, 0.5);
  const std::vector<Contradiction> found = pieces.found();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].first, kCount + 5);
  EXPECT_EQ(found[0].last, kCount + 11);
  EXPECT_EQ(found[0].loop_count, 7U);
  EXPECT_EQ(found[0].off_count, 3U);
  EXPECT_EQ(found[0].earlier, 8U);
  EXPECT_EQ(found[0].later, kCount + 8);
  EXPECT_NEAR(found[0].off_m, 0.75, 1e-12);
}

TEST(Contradictions, DoNotDependOnTheOrderOfLoops) {
  TwoPieces pieces;
  for (const std::uint32_t i : {0U, 1U, 2U}) pieces.put_off(i, 1.0);
  const std::vector<Contradiction> expected = pieces.found();
  ASSERT_EQ(expected.size(), 1U);
  for (GraphEdge& loop : pieces.loops) {
    loop = {loop.to, loop.from, loop.T_from_to.inverse(), loop.sigma_m, loop.sigma_rad};
  }
  std::swap(pieces.loops[0], pieces.loops[7]);
  std::swap(pieces.loops[2], pieces.loops[11]);
  const std::vector<Contradiction> found = pieces.found();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].first, expected[0].first);
  EXPECT_EQ(found[0].last, expected[0].last);
  EXPECT_EQ(found[0].off_count, 3U);
}

TEST(Contradictions, OfOnePairAreNotHiddenByLoopsToAnotherPiece) {
  TwoPieces pieces;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    if (i % 3 == 0) pieces.put_off(i, 1.0);
    if (i % 3 != 0) pieces.odometry.piece[i] = 7;
  }
  const std::vector<Contradiction> found = pieces.found();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].loop_count, 4U);
  EXPECT_EQ(found[0].off_count, 4U);
}

TEST(Contradictions, NameDrivesAndScans) {
  Drive drive;
  drive.name = "mon";
  drive.later_parts = {"tue"};
  for (std::uint32_t i = 0; i < 2 * kCount; ++i) {
    ScanInfo scan;
    scan.part = i / kCount;
    scan.recording_index = 100 + i;
    drive.scans.push_back(scan);
  }
  TwoPieces pieces;
  for (const std::uint32_t i : {1U, 2U, 3U}) pieces.put_off(i, 0.5);
  pieces.put_off(2, 0.5);
  TestContext ctx;
  std::vector<Notice> notices;
  warn_of_contradictions(ctx, drive, pieces.found(), notices);
  warn_of_contradictions(ctx, drive, {}, notices);
  ASSERT_EQ(notices.size(), 1U);
  EXPECT_EQ(notices[0].code, "loops-contradict-poses");
  EXPECT_EQ(notices[0].text, ctx.warnings[0]);
  EXPECT_GT(notices[0].amount, 0.25);
  EXPECT_THAT(ctx.warnings,
              ElementsAre(AllOf(
                  HasSubstr("drive tue, scans 112 to 118: 3 of 7 loops"),
                  HasSubstr("most at scan 114 (1.00 m, matched with scan 102 of drive mon)"))));
}

constexpr std::size_t kScansADay = 16;  // scans of each drive

// Drives along one street, a metre a scan; what each measures is so many times what is there.
TestDrive drives(const std::vector<double>& scales, std::size_t count = kScansADay) {
  std::vector<TestDrive> days;
  for (const double scale : scales) {
    const std::vector<Pose> way = along_street(0.4 * static_cast<double>(days.size()), count);
    days.push_back(scaled(drive_through(random_street(4), way, 0.5), scale));
  }
  return joined_days(days);
}

std::vector<ScaleDifference> differences(const TestDrive& all, std::size_t from = 0,
                                         int threads = 1) {
  return value_of(find_scale_differences(TestContext(threads), all.drive, all.truth, from));
}

TEST(DriveScales, AreTheRatiosOfALaterDrivesDistances) {
  for (const double scale : {0.97, 0.992, 1.006, 1.01, 1.02}) {
    const std::vector<ScaleDifference> found = differences(drives({1.0, scale}));
    ASSERT_EQ(found.size(), 1U) << scale;
    EXPECT_EQ(found[0].earlier, 0U);
    EXPECT_EQ(found[0].later, 1U);
    EXPECT_NEAR(found[0].ratio, scale, 0.0025);
    EXPECT_EQ(found[0].scan_count, 4U);
  }
}

TEST(DriveScales, AreSilentWhereDrivesAgree) {
  EXPECT_TRUE(differences(drives({1.0, 1.0, 1.001})).empty());
  EXPECT_TRUE(differences(drives({1.02})).empty());
}

TEST(DriveScales, NameThePairsOfTheDriveThatDiffers) {
  const TestDrive all = drives({1.0, 1.01, 1.0});
  const std::vector<ScaleDifference> found = differences(all);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].later, 1U);
  EXPECT_NEAR(found[0].ratio, 1.01, 0.0025);
  EXPECT_EQ(found[1].earlier, 1U);
  EXPECT_EQ(found[1].later, 2U);
  EXPECT_NEAR(found[1].ratio, 1.0 / 1.01, 0.0025);
  EXPECT_THAT(to_text(found[1], all.drive),
              HasSubstr("drive day 3 measures distances 0.9 % shorter than drive day 2"));
}

TEST(DriveScales, JudgeNoScanBeforeThoseThatAreNew) {
  const std::vector<ScaleDifference> found = differences(drives({1.0, 1.01, 1.0}), 2 * kScansADay);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].later, 2U);
}

TEST(DriveScales, NeedThreeScans) {
  EXPECT_TRUE(differences(drives({1.0, 1.02}, 4)).empty());
  EXPECT_EQ(differences(drives({1.0, 1.02}, 10)).size(), 1U);
}

// The later drive went through another street than its poses.
TEST(DriveScales, NeedScansThatFit) {
  for (const std::uint64_t street : {5U, 12U}) {
    TestDrive all = drives({1.0, 1.0});
    std::vector<Pose> poses;
    for (const TrajectoryPose& pose : all.truth.poses) poses.push_back(pose.T_map_vehicle);
    std::vector<Scan> scans = scans_of(drive_through(random_street(street), poses, 0.5).drive);
    for (std::size_t i = 0; i < kScansADay; ++i) scans[i] = *all.drive.store->read(i);
    all.drive.store = memory_scan_store(scans);
    EXPECT_TRUE(differences(all).empty()) << street;
  }
}

TEST(DriveScales, DoNotDependOnThreads) {
  const TestDrive all = drives({1.0, 1.013, 0.99});
  const std::vector<ScaleDifference> by_one = differences(all);
  const std::vector<ScaleDifference> by_three = differences(all, 0, 3);
  ASSERT_EQ(by_one.size(), 3U);
  ASSERT_EQ(by_three.size(), by_one.size());
  for (std::size_t i = 0; i < by_one.size(); ++i) EXPECT_EQ(by_one[i].ratio, by_three[i].ratio);
}

// Its loops are met within 0.25 m.
TEST(DriveScales, AreWarnedOfWithTheTrajectory) {
  for (const double scale : {1.0, 1.01}) {
    TestDrive all = drives({1.0, scale});
    for (ScanInfo& scan : all.drive.scans) scan.T_world_vehicle.reset();
    TestContext ctx(2);
    EXPECT_EQ(value_of(estimate_trajectory(ctx, {}, all.drive)).poses.back().piece, 0U);
    if (scale == 1.0) {
      EXPECT_THAT(ctx.warnings, IsEmpty());
    } else {
      EXPECT_THAT(
          ctx.warnings,
          ElementsAre(HasSubstr("drive day 2 measures distances 1.0 % longer than drive ")));
    }
  }
}

const std::vector<Eigen::Vector3d> kPoints_m = {{10.0, 0.0, 0.0}};

// Of a scan that fits best at a scale; its logarithm is a parabola.
MatchAtScale best_at(double scale, bool is_sure = true) {
  return [=](const std::vector<Eigen::Vector3d>& scaled_m) {
    const double off = scaled_m[0].x() / kPoints_m[0].x() - scale;
    return FitAtScale{2.0 * std::exp(-off * off / (2.0 * 0.02 * 0.02)), is_sure};
  };
}

TEST(BestScale, IsTheTopOfTheParabola) {
  for (double scale = 0.966; scale <= 1.034; scale += 0.0013) {
    const std::optional<double> found = best_scale(kPoints_m, best_at(scale));
    ASSERT_TRUE(found.has_value()) << scale;
    EXPECT_NEAR(*found, scale, 1e-9);
  }
}

TEST(BestScale, IsNotKnownBeyondTheScalesThatAreTriedOrWhereNoMatchIsSure) {
  EXPECT_FALSE(best_scale(kPoints_m, best_at(0.95)));
  EXPECT_FALSE(best_scale(kPoints_m, best_at(1.05)));
  EXPECT_FALSE(best_scale(kPoints_m, best_at(1.0, false)));
}

TEST(BestScale, MatchesEachScaleOnce) {
  std::multiset<double> tried;
  const MatchAtScale match = [&](const std::vector<Eigen::Vector3d>& scaled_m) {
    tried.insert(scaled_m[0].x());
    return best_at(1.013)(scaled_m);
  };
  ASSERT_TRUE(best_scale(kPoints_m, match));
  EXPECT_EQ(std::set<double>(tried.begin(), tried.end()).size(), tried.size());
  EXPECT_LE(tried.size(), 12U);
}

TEST(CommonRatio, IsTheMedianOfScansThatAgree) {
  EXPECT_EQ(common_ratio({1.01, 1.012, 1.008}), 1.01);
  EXPECT_EQ(common_ratio({0.99, 0.992, 1.0, 0.988}), 0.992) << "three of four";
  EXPECT_EQ(common_ratio({0.99, 0.992, 1.0, 1.001}), 1.0) << "two of four";
  EXPECT_EQ(common_ratio({1.0029, 1.0029, 1.0029}), 1.0) << "too little";
  EXPECT_EQ(common_ratio({1.01, 1.01}), 1.0) << "too few";
  EXPECT_EQ(common_ratio({}), 1.0);
}

}  // namespace
}  // namespace sightline
