#include "passes/localize/import_errors.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "passes/localize/measure_error.h"
#include "tests/support/value_of.h"
#include "tests/support/whole_rows.h"

namespace sightline {
namespace {

// A drive along x with a scan every metre; those of odd recording index are localized.
struct World {
  Drive drive;
  Trajectory trajectory;
  Sites sites;
};

World straight_world(std::uint32_t count) {
  World world;
  world.drive.name = "second";
  for (std::uint32_t i = 0; i < count; ++i) {
    const Pose pose(Eigen::Translation3d(i, 0.2, 0.0));
    ScanInfo& info = world.drive.scans.emplace_back();
    info.recording_index = 2 * i + 1;
    world.trajectory.poses.push_back({info.recording_index, i, pose});
    Site site;
    site.s_m = i;
    site.T_map_vehicle = Pose(Eigen::Translation3d(i, 0.0, 0.0));
    world.sites.sites.push_back(site);
  }
  return world;
}

ImportErrorsOptions two_ranges() {
  ImportErrorsOptions options{.ranges_m = {10.0, 20.0}};
  options.site_radius_m = 0.5;
  return options;
}

// Of each scan named: at both ranges three starts, errors that tell where they come from.
OutsideErrors errors_of(const std::vector<std::uint32_t>& scans) {
  OutsideErrors outside;
  outside.file = "errors.csv";
  outside.localizer = {"my-ndt", 2, {{"leaf_m", "0.5"}}};
  std::uint32_t line = 1;
  for (const std::uint32_t scan : scans) {
    for (const double range_m : {10.0, 20.0}) {
      for (std::uint32_t start = 0; start < 3; ++start) {
        const double error_m = 0.1 * scan + (range_m > 15.0 ? 0.0 : 0.2) + 0.03 * (2 - start);
        outside.errors.push_back({scan, range_m, start, error_m, ++line});
      }
    }
  }
  return outside;
}

Result<MeasuredError> import(const World& world, const OutsideErrors& outside,
                             std::vector<std::string>* warnings = nullptr,
                             const ImportErrorsOptions& options = two_ranges()) {
  PassContext ctx;
  ctx.warning_sink = [&](const std::string& warning) {
    if (warnings != nullptr) warnings->push_back(warning);
  };
  return of_ranges(
      import_errors(ctx, options, outside, world.drive, world.trajectory, world.sites));
}

TEST(ImportErrors, GivesEachSiteTheErrorsOfItsScanOverAllStarts) {
  std::vector<std::string> warnings;
  const MeasuredError measured = value_of(import(straight_world(4), errors_of({1, 5}), &warnings));
  EXPECT_TRUE(validate(measured));
  EXPECT_EQ(measured.scan_of_site, (std::vector<std::int64_t>{1, -1, 5, -1}));
  EXPECT_EQ(measured.matching.localizer, (LocalizerProfile{"my-ndt", 2, {{"leaf_m", "0.5"}}}));
  EXPECT_EQ(measured.matching.site_step, 2u) << "every second site was measured";
  const ErrorRow& row = measured.row(0, 0);  // 0.30, 0.33, 0.36
  EXPECT_NEAR(row.mean_m, 0.33, 1e-15);
  EXPECT_NEAR(row.median_m, 0.33, 1e-15);
  EXPECT_NEAR(row.p90_m, 0.354, 1e-15);
  EXPECT_NEAR(row.max_m, 0.36, 1e-15);
  EXPECT_EQ(row.lost_share, 0.0);
  EXPECT_NEAR(measured.row(2, 1).lost_share, 2.0 / 3.0, 1e-15) << "0.50, 0.53 and 0.56 m";
  EXPECT_EQ(measured.row(1, 0).mean_m, 0.0);
  EXPECT_TRUE(warnings.empty());
}

TEST(ImportErrors, MovesWithTheFrameAndNeverNamesAFartherScan) {
  World world = straight_world(30);
  const MeasuredError here = value_of(import(world, errors_of({1, 21, 41})));
  world.trajectory.frame.origin_world_m.x() -= 64.0;
  for (TrajectoryPose& pose : world.trajectory.poses) pose.T_map_vehicle.translation().x() += 64.0;
  EXPECT_EQ(to_bytes(here), to_bytes(value_of(import(world, errors_of({1, 21, 41})))));
  for (std::size_t site = 0; site < 30; ++site) {
    EXPECT_EQ(here.scan_of_site[site],
              site % 10 == 0 ? static_cast<std::int64_t>(2 * site + 1) : -1);
  }
  EXPECT_EQ(here.matching.site_step, 10u);
}

TEST(ImportErrors, AScanStandsForAllThatLiesBetweenItAndTheNext) {
  ImportErrorsOptions options = two_ranges();
  options.site_radius_m = 1.5;  // three sites take each scan
  const MeasuredError measured =
      value_of(import(straight_world(30), errors_of({11, 31, 51}), nullptr, options));
  EXPECT_EQ(std::ranges::count(measured.scan_of_site, 31), 3);
  EXPECT_EQ(measured.matching.site_step, 10u);
}

TEST(ImportErrors, CountsTheScansThatNoSiteTakes) {
  World world = straight_world(4);
  world.trajectory.poses[3].T_map_vehicle.translation().y() = 5.0;
  std::vector<std::string> warnings;
  ASSERT_TRUE(import(world, errors_of({1, 7}), &warnings));
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("1 of 2 imported scans"), std::string::npos) << warnings[0];
}

TEST(ImportErrors, RefusesAtTheLineWhatDoesNotBelongToTheDriveOrTheRanges) {
  const World world = straight_world(4);
  const auto refused = [&](const OutsideErrors& outside, const char* place, const char* message) {
    const Error measured = failure_of(import(world, outside), message);
    EXPECT_EQ(measured.code, ErrorCode::kMismatchedInputs);
    EXPECT_EQ(measured.place, place) << to_string(measured);
    EXPECT_EQ(measured.file, "errors.csv");
    EXPECT_NE(measured.message.find(message), std::string::npos) << to_string(measured);
  };
  refused(errors_of({1, 9}), "line 8", "found scan 9, expected one of the 4 scans");
  OutsideErrors outside = errors_of({1, 3});
  outside.errors[9].range_m = 21.0;
  refused(outside, "line 11",
          "found a look of 21 m, expected one of annotation.ranges_m: 10, 20 m");
  outside = errors_of({1, 3});
  outside.errors.erase(outside.errors.begin() + 7);
  refused(outside, "line 10", "scan 3 has no error for a look of 10 m and start 1");
  outside = errors_of({1, 3});
  outside.errors.pop_back();
  refused(outside, "line 12", "scan 3 has no error for a look of 20 m and start 2");
  outside = errors_of({1, 3});
  outside.errors.push_back({3, 20.0, 3, 0.1, 14});
  refused(outside, "line 14", "scan 3 has more starts than the first scan, which has 3");
  outside = errors_of({1});
  outside.errors.erase(outside.errors.begin() + 3, outside.errors.end());
  refused(outside, "line 4", "look of 20 m and start 0");
}

TEST(ImportErrors, RefusesScansThatMadeTheMap) {
  ImportErrorsOptions options = two_ranges();
  options.scans = ScanSelection::kEven;  // all scans of this drive are odd
  const Error refused = failure_of(import(straight_world(4), errors_of({1}), nullptr, options));
  EXPECT_NE(refused.message.find("(the others made the map)"), std::string::npos)
      << to_string(refused);
}

TEST(ImportErrors, RefusesADriveThatIsNowhereNear) {
  World world = straight_world(4);
  for (TrajectoryPose& pose : world.trajectory.poses) pose.T_map_vehicle.translation().y() = 50.0;
  EXPECT_EQ(failure_of(import(world, errors_of({1}))).code, ErrorCode::kNoOverlap);
}

}  // namespace
}  // namespace sightline
