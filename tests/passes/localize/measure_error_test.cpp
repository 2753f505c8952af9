#include "passes/localize/measure_error.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <span>

#include "passes/localize/pcl/pcl_ndt.h"
#include "passes/map/build_ndt.h"
#include "passes/matching/covariance/known_start.h"
#include "passes/matching/look_cutter.h"
#include "passes/matching/match_starts.h"
#include "passes/matching/scan_preparation.h"
#include "tests/passes/matching/random_scene.h"
#include "tests/support/kept_parts.h"
#include "tests/support/value_of.h"
#include "tests/support/whole_rows.h"

namespace sightline {
namespace {

// A drive through the room of random_scene.h: a scan every metre from x = -4 to 4, its poses exact.
struct World {
  NdtMap map;
  Drive drive;
  Trajectory trajectory;
  Sites sites;
};

// T_map_room: where the room is.
World make_world(const Pose& T_map_room = Pose::Identity()) {
  World world;
  world.map = ndt_from_points(transformed(T_map_room, room_points(1, 30000, 0.02)), MapFrame{},
                              BuildNdtOptions{}, 1);
  world.drive.name = "second";
  world.drive.sensor.T_vehicle_lidar.translation().z() = 0.5;
  world.drive.sensor.azimuth_step_deg = 1.5;  // about 4000 returns of 16 beams
  std::vector<Scan> scans;
  for (int i = 0; i < 9; ++i) {
    Pose T_map_vehicle = Pose(Eigen::Translation3d(i - 4.0, 0.1, 0.0));
    T_map_vehicle.linear() =
        Eigen::AngleAxisd(0.3 * i, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    const Pose T_lidar_map = (T_map_vehicle * world.drive.sensor.T_vehicle_lidar).inverse();
    Scan scan;
    scan.stamp_ns = i;
    scan.points_m =
        transformed(T_lidar_map, room_points(50 + static_cast<std::uint64_t>(i), 4000, 0.02));
    scans.push_back(scan);
    ScanInfo& info = world.drive.scans.emplace_back();
    info.recording_index = static_cast<std::uint32_t>(2 * i);
    info.stamp_ns = i;
    info.point_count = scan.points_m.size();
    world.trajectory.poses.push_back(
        {static_cast<std::uint32_t>(2 * i), i, T_map_room * T_map_vehicle});
    Site site;
    site.s_m = i;
    site.T_map_vehicle = T_map_vehicle;
    site.T_map_vehicle.translation().y() = 0.0;
    site.T_map_vehicle = T_map_room * site.T_map_vehicle;
    world.sites.sites.push_back(site);
  }
  world.drive.store = memory_scan_store(scans);
  return world;
}

// Starts within the basin of the room's thin walls.
MeasureErrorOptions two_ranges() {
  MeasureErrorOptions options;
  options.starts.radius_m = 0.25;
  options.ranges_m = {6.0, 12.0};
  options.looks = {};
  return options;
}

MeasureErrorOptions two_looks() {
  MeasureErrorOptions options = two_ranges();
  options.looks = {
      {.range_m = 20.0, .return_count = 1500, .point_count = 100, .is_by_normals = true},
      {.range_m = 20.0, .return_count = 1500, .mode = LookMode::kSettle}};
  return options;
}

Result<ByFamily<MeasuredError>> measure_both(const World& world, const MeasureErrorOptions& options,
                                             int threads = 1) {
  PassContext ctx;
  ctx.threads = threads;
  return whole_rows(
      measure_error(ctx, options, world.drive, world.trajectory, world.map, world.sites));
}

Result<MeasuredError> measure(const World& world, const MeasureErrorOptions& options,
                              int threads = 1) {
  return of_ranges(measure_both(world, options, threads));
}

void forget_times(ErrorRow& row) {
  row.mean_time_ms = row.max_time_ms = row.tracking_time_ms = 0.0;
}

std::vector<std::byte> bytes_without_times(ByFamily<MeasuredError> measured) {
  visit_families(measured, [](MeasuredError& of_family) {
    for (ErrorRow& row : of_family.rows) forget_times(row);
  });
  return to_bytes(measured);
}

TEST(MeasureError, StartsFromTheTwelveOffsetsOfTheDefinition) {
  const std::vector<InitialOffset> offsets = initial_offsets(StartPattern{});
  ASSERT_EQ(offsets.size(), 12u);
  EXPECT_NEAR(offsets[0].x_m, std::sqrt(0.5 / 12.0), 1e-15);
  EXPECT_NEAR(offsets[0].y_m, 0.0, 1e-15);
  EXPECT_NEAR(offsets[1].x_m, std::sqrt(1.5 / 12.0) * std::cos(2.399963229728653), 1e-15);
  EXPECT_NEAR(offsets[1].y_m, std::sqrt(1.5 / 12.0) * std::sin(2.399963229728653), 1e-15);
  // k = 1: 5 of 0..11 is -1/11 of a degree, 7 is +3/11 of 0.1 m.
  EXPECT_NEAR(offsets[1].yaw_rad, -1.0 / 11.0 * std::numbers::pi / 180.0, 1e-15);
  EXPECT_NEAR(offsets[1].z_m, 0.3 / 11.0, 1e-15);
  double yaw_sum_rad = 0.0;
  for (const InitialOffset& offset : offsets) {
    EXPECT_LT(std::hypot(offset.x_m, offset.y_m), 1.0);
    yaw_sum_rad += offset.yaw_rad;
  }
  EXPECT_NEAR(yaw_sum_rad, 0.0, 1e-15);
}

TEST(MeasureError, FindsSmallErrorsWhereTheWholeRoomIsSeen) {
  const MeasuredError measured = value_of(measure(make_world(), two_ranges()));
  ASSERT_TRUE(validate(measured).has_value());
  ASSERT_EQ(measured.rows.size(), 18u);
  EXPECT_EQ(measured.scan_of_site[3], 6);
  for (std::size_t site = 0; site < 9; ++site) {
    const ErrorRow& near = measured.row(site, 0);
    const ErrorRow& far = measured.row(site, 1);
    EXPECT_LT(far.mean_m, 0.05);
    EXPECT_EQ(far.lost_share, 0.0);
    EXPECT_GT(far.point_count, near.point_count);
    EXPECT_GT(far.mean_iterations, 1.0);
  }
}

TEST(MeasureError, KeepsTheOrderOfItsOwnStatistics) {
  MeasureErrorOptions options = two_ranges();
  options.localizer = LocalizerKind::kPlain;  // each of its evaluations is of all points
  const MeasuredError measured = value_of(measure(make_world(), options));
  for (const ErrorRow& row : measured.rows) {
    EXPECT_LE(row.median_m, row.p90_m);
    EXPECT_LE(row.p90_m, row.max_m);
    EXPECT_LE(row.mean_m, row.max_m + 1e-12);
    EXPECT_LE(row.longitudinal_m, row.mean_m + 1e-12);
    EXPECT_LE(row.lateral_m, row.mean_m + 1e-12);
    EXPECT_LE(row.mean_work, row.max_work);
    EXPECT_NEAR(row.mean_work, row.mean_iterations * row.point_count, 1e-6 * row.mean_work);
    EXPECT_LE(row.mean_time_ms, row.max_time_ms + 1e-12);
  }
}

TEST(MeasureError, WithoutPointsInRangeReportsTheOffsetsThemselves) {
  World world = make_world();
  MeasureErrorOptions options = two_ranges();
  options.starts.radius_m = 1.0;
  options.ranges_m = {1.0};  // the sensor hangs higher than this over the floor
  const MeasuredError measured = value_of(measure(world, options));
  double expected_m = 0.0;
  for (const InitialOffset& offset : initial_offsets(starts_of(options))) {
    expected_m += std::hypot(offset.x_m, offset.y_m, offset.z_m) / 12.0;
  }
  EXPECT_EQ(measured.rows[4].point_count, 0u);
  EXPECT_NEAR(measured.rows[4].mean_m, expected_m, 1e-12);
  EXPECT_NEAR(measured.rows[4].lost_share, 0.75, 1e-12) << "sqrt((k + .5) / 12) > .5 from k = 3 on";
}

TEST(MeasureError, GivesTheSameBytesForAnyNumberOfThreads) {
  const World world = make_world();
  const auto bytes = [&](int threads) {
    Result<MeasuredError> measured = measure(world, two_ranges(), threads);
    for (ErrorRow& row : measured->rows) forget_times(row);
    return to_bytes(*measured);
  };
  const std::vector<std::byte> one = bytes(1);
  EXPECT_EQ(one, bytes(2));
  EXPECT_EQ(one, bytes(3));
}

TEST(MeasureError, DoesNotDependOnTheFrameThatTheTrajectoryIsToldIn) {
  World world = make_world();
  const Result<MeasuredError> expected = measure(world, two_ranges());
  MapFrame other;
  other.origin_world_m = Eigen::Vector3d(-640.0, 128.0, 64.0);
  world.trajectory = rebase(world.trajectory, other);
  const Result<MeasuredError> measured = measure(world, two_ranges());
  ASSERT_TRUE(expected.has_value() && measured.has_value());
  for (std::size_t i = 0; i < expected->rows.size(); ++i) {
    EXPECT_NEAR(measured->rows[i].mean_m, expected->rows[i].mean_m, 1e-9);
  }
}

TEST(MeasureError, TakesTheMatchAtFullRangeAsReferenceWhenAsked) {
  World world = make_world();
  MeasureErrorOptions options = two_ranges();
  options.ranges_m = {100.0};
  options.reference = ErrorReference::kFullRangeMatch;
  const MeasuredError measured = value_of(measure(world, options));
  EXPECT_EQ(measured.reference, ErrorReference::kFullRangeMatch);
  for (const ErrorRow& row : measured.rows) EXPECT_LT(row.mean_m, 0.02);
}

// Its reference would be a match to this very map, believed to be the truth.
TEST(MeasureError, KnowsNoPoseOfADriveThatWasPlacedByMatchingAndSaysSo) {
  World world = make_world();
  world.trajectory.source = PoseSource::kEstimated;
  MeasureErrorOptions options = two_ranges();
  options.reference = ErrorReference::kKnownPose;
  std::string warning;
  PassContext ctx;
  ctx.warning_sink = [&](const std::string& message) { warning = message; };
  const MeasuredError measured = value_of(of_ranges(whole_rows(
      measure_error(ctx, options, world.drive, world.trajectory, world.map, world.sites))));
  EXPECT_EQ(measured.reference, ErrorReference::kFullRangeMatch);
  EXPECT_NE(warning.find("has no given poses"), std::string::npos) << warning;
}

TEST(MeasureError, SaysHowFarFromThePosesThatScansCameWith) {
  const World world = make_world();
  MeasureErrorOptions options = two_ranges();
  const Result<MeasuredError> full = measure(world, options);
  options.reference = ErrorReference::kKnownPose;
  const Result<MeasuredError> known = measure(world, options);
  ASSERT_TRUE(full.has_value() && known.has_value());
  bool differs = false;
  for (std::size_t i = 0; i < full->rows.size(); ++i) {
    EXPECT_NEAR(known->rows[i].from_given_m, known->rows[i].mean_m, 1e-12);
    differs = differs || std::abs(full->rows[i].from_given_m - full->rows[i].mean_m) > 1e-4;
  }
  EXPECT_TRUE(differs) << "the match at full range is another reference";
}

// Mean error of the scan of a site over starts of which each goes its own way, as a vehicle does.
double mean_alone_m(const World& world, const MeasureErrorOptions& options, const Localizer& own,
                    const Look& look, std::size_t site) {
  const Localizer of_samples = localizer_for_samples(own, world.map);
  LookMatcher matcher({own, of_samples, world.drive.sensor, options.leaf_m});
  const Scan scan = *world.drive.store->read(site);
  const Pose& T_map_vehicle = world.trajectory.poses[site].T_map_vehicle;
  matcher.take(scan, every_return(world.drive.sensor.max_range_m));
  const Pose T_map_reference = matcher.match(T_map_vehicle).T_map_sensor;
  matcher.take(scan, look);
  double sum_m = 0.0;
  const std::vector<InitialOffset> offsets = initial_offsets(starts_of(options));
  for (const InitialOffset& offset : offsets) {
    const MatchResult found = matcher.match(T_map_reference * start_pose(offset));
    sum_m += (found.T_map_sensor.translation() - T_map_reference.translation()).norm();
  }
  return sum_m / static_cast<double>(offsets.size());
}

TEST(MeasureError, StartsThatShareClimbsEndNearWhereEachEndsAlone) {
  const World world = make_world();
  const MeasureErrorOptions options = two_looks();
  const ByFamily<MeasuredError> both = value_of(measure_both(world, options));
  const auto& [measured, samples] = both;
  const Localizer own = make_localizer(world.map, localizer_options(options.localizer));
  bool differs = false;
  for (std::size_t site = 0; site < world.sites.sites.size(); ++site) {
    for (std::size_t range = 0; range < options.ranges_m.size(); ++range) {
      const double alone_m =
          mean_alone_m(world, options, own, every_return(options.ranges_m[range]), site);
      EXPECT_NEAR(measured.row(site, range).mean_m, alone_m, 0.005);
      differs = differs || std::abs(measured.row(site, range).mean_m - alone_m) > 1e-12;
    }
    EXPECT_NEAR(samples->row(site, 0).mean_m,
                mean_alone_m(world, options, own, options.looks.front(), site), 1e-12)
        << "a cut that depends on its start is its own";
  }
  EXPECT_TRUE(differs);
}

// Ends of a site's scan from these starts, each by itself. `pattern`: of tracking starts, whose
// covariance is given; else null.
std::vector<AxisErrors> ends_alone(const World& world, const Localizer& own, const Look& look,
                                   const std::vector<InitialOffset>& starts, std::size_t site,
                                   const TrackingPattern* pattern = nullptr) {
  const StructureMap structures(world.map);
  StructureObserver memory;
  const Localizer sampling = localizer_for_samples(own, world.map);
  LookMatcher matcher({own, sampling, world.drive.sensor, 1.0});
  const Scan scan = *world.drive.store->read(site);
  const Pose T_vehicle_map = world.trajectory.poses[site].T_map_vehicle.inverse(Eigen::Isometry);
  matcher.take(scan, look);
  std::vector<AxisErrors> ends;
  for (const InitialOffset& start : starts) {
    const Pose T_map_start = world.trajectory.poses[site].T_map_vehicle * start_pose(start);
    Pose T_map_end;
    if (pattern == nullptr) {
      T_map_end = matcher.match(T_map_start).T_map_sensor;
    } else {
      const KnownStart known{
          T_map_start,
          tracking_covariance(*pattern, world.trajectory.poses[site].T_map_vehicle.linear())};
      const MatchResult found = matcher.match(
          T_map_start,
          3.0 * std::sqrt(known.covariance.topLeftCorner<2, 2>().norm() / std::numbers::sqrt2));
      T_map_end = end_of_match(found, matcher.scan(), &known, structures,
                               default_information_scale(), memory)
                      .estimate.T_map_vehicle;
    }
    const Pose end = T_vehicle_map * T_map_end;
    ends.push_back({static_cast<float>(end.translation().x()),
                    static_cast<float>(end.translation().y()),
                    static_cast<float>(end.translation().z()),
                    static_cast<float>(std::atan2(end(1, 0), end(0, 0)))});
  }
  return ends;
}

void expect_near(const AxisErrors& a, const AxisErrors& b, double within) {
  EXPECT_NEAR(a.longitudinal_m, b.longitudinal_m, within);
  EXPECT_NEAR(a.lateral_m, b.lateral_m, within);
  EXPECT_NEAR(a.height_m, b.height_m, within);
  EXPECT_NEAR(a.yaw_rad, b.yaw_rad, within);
}

TEST(MeasureError, KeepsTheEndOfEachTrackingStartAndTheFiguresOfTheOthers) {
  const World world = make_world();
  MeasureErrorOptions options = two_looks();
  options.reference = ErrorReference::kKnownPose;
  const ByFamily<MeasuredError> both = value_of(measure_both(world, options));
  const MeasuredError& measured = *both.samples;
  ASSERT_EQ(measured.tracking_offsets.size(), 5U);
  const Localizer own = make_localizer(world.map, localizer_options(options.localizer));
  for (std::size_t site = 0; site < world.sites.sites.size(); ++site) {
    for (std::size_t look = 0; look < 2; ++look) {
      const std::vector<AxisErrors> tracking = ends_alone(
          world, own, options.looks[look], measured.tracking_offsets, site, &options.tracking);
      for (std::size_t k = 0; k < tracking.size(); ++k) {
        expect_near(measured.tracking(site, look)[k], tracking[k], 1e-6);
      }
      // Mean and deviation in the plain way, of the twelve starts.
      const std::vector<AxisErrors> ends =
          ends_alone(world, own, options.looks[look], measured.offsets, site);
      double sum_m = 0.0;
      double squares_m2 = 0.0;
      for (const AxisErrors& end : ends) {
        sum_m += double{end.lateral_m};
        squares_m2 += double{end.lateral_m} * double{end.lateral_m};
      }
      const double mean_m = sum_m / 12.0;
      const DirectionErrors& directions = measured.row(site, look).directions;
      EXPECT_NEAR(directions.mean.lateral_m, mean_m, 1e-6);
      EXPECT_NEAR(directions.deviation.lateral_m,
                  std::sqrt(std::max(0.0, squares_m2 / 12.0 - mean_m * mean_m)), 1e-5);
    }
  }
}

TEST(MeasureError, TrackingStartsDoNotChangeTheRows) {
  const World world = make_world();
  MeasureErrorOptions options = two_looks();
  ByFamily<MeasuredError> with = value_of(measure_both(world, options));
  options.tracking.count = 0;
  const ByFamily<MeasuredError> without = value_of(measure_both(world, options));
  visit_families(with, [](MeasuredError& of_family) {
    for (ErrorRow& row : of_family.rows) {
      EXPECT_GT(row.tracking_work, 0.0);
      row.tracking_work = 0.0;
    }
    of_family.tracking_offsets.clear();
    of_family.tracking_ends.clear();
  });
  EXPECT_EQ(bytes_without_times(with), bytes_without_times(without));
}

TEST(MeasureError, OfATurnedWorldIsTheSameInTheVehiclesAxes) {
  MeasureErrorOptions options = two_ranges();
  options.reference = ErrorReference::kKnownPose;
  const MeasuredError measured = value_of(measure(make_world(), options));
  Pose quarter_turn = Pose::Identity();
  quarter_turn.linear() << 0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0;  // cells stay cells
  const MeasuredError turned = value_of(measure(make_world(quarter_turn), options));
  ASSERT_EQ(turned.tracking_ends.size(), measured.tracking_ends.size());
  for (std::size_t i = 0; i < turned.tracking_ends.size(); ++i) {
    expect_near(turned.tracking_ends[i], measured.tracking_ends[i], 1e-3);
  }
  for (std::size_t i = 0; i < turned.rows.size(); ++i) {
    expect_near(turned.rows[i].directions.mean, measured.rows[i].directions.mean, 1e-3);
    expect_near(turned.rows[i].directions.deviation, measured.rows[i].directions.deviation, 1e-3);
  }
}

TEST(MeasureError, KeepsTheWholeStartWhereThereIsNothingToMatch) {
  MeasureErrorOptions options = two_ranges();
  options.ranges_m = {1.0};
  options.reference = ErrorReference::kKnownPose;
  const MeasuredError measured = value_of(measure(make_world(), options));
  for (std::size_t site = 0; site < 9; ++site) {
    const DirectionErrors tracking =
        direction_errors(measured.tracking_offsets, measured.tracking(site, 0));
    for (const DirectionErrors& errors : {tracking, measured.row(site, 0).directions}) {
      expect_near(errors.kept, {1.0F, 1.0F, 1.0F, 1.0F}, 1e-5);
    }
    EXPECT_NEAR(tracking.deviation.longitudinal_m, 0.141, 1e-6);
    EXPECT_NEAR(tracking.deviation.yaw_rad, 0.5 * std::numbers::pi / 180.0, 1e-6);
  }
}

TEST(MeasureError, RefusesFewerThanFiveTrackingStarts) {
  MeasureErrorOptions options = two_ranges();
  options.tracking.count = 4;
  EXPECT_EQ(failure_of(measure(make_world(), options)).code, ErrorCode::kBadValue);
}

TEST(MeasureError, CountsSitesWithoutAScan) {
  World world = make_world();
  world.sites.sites[2].T_map_vehicle.translation().y() = 5.0;
  std::vector<std::string> warnings;
  std::size_t last_done = 0;
  PassContext ctx;
  ctx.warning_sink = [&](const std::string& message) { warnings.push_back(message); };
  ctx.progress_sink = [&](std::size_t done, std::size_t) { last_done = done; };
  const MeasuredError measured = value_of(of_ranges(whole_rows(
      measure_error(ctx, two_ranges(), world.drive, world.trajectory, world.map, world.sites))));
  EXPECT_EQ(measured.scan_of_site[2], -1);
  EXPECT_EQ(measured.row(2, 1).point_count, 0u);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("1 of 9 sites"), std::string::npos);
  EXPECT_EQ(last_done, 1u) << "nine sites are one part of the work";
}

TEST(MeasureError, UsesOnlyTheSelectedScans) {
  World world = make_world();
  for (std::size_t i = 0; i < 9; ++i) {
    world.drive.scans[i].recording_index = static_cast<std::uint32_t>(i);
    world.trajectory.poses[i].recording_index = static_cast<std::uint32_t>(i);
  }
  MeasureErrorOptions options = two_ranges();
  options.scans = ScanSelection::kOdd;
  options.site_radius_m = 1.5;
  const MeasuredError measured = value_of(measure(world, options));
  for (const std::int64_t scan : measured.scan_of_site) EXPECT_EQ(scan % 2, 1);
}

class LimitedStore : public ScanStore {
 public:
  LimitedStore(std::shared_ptr<const ScanStore> store, int limit)
      : store_(std::move(store)), left_(limit) {}
  Result<Scan> read(std::size_t index) const override {
    if (left_-- <= 0) return Error{ErrorCode::kTruncatedScan, "interrupted"};
    return store_->read(index);
  }
  [[nodiscard]] int left() const { return left_; }

 private:
  std::shared_ptr<const ScanStore> store_;
  mutable std::atomic<int> left_;
};

TEST(MeasureError, GoesOnWhereAnInterruptedRunStopped) {
  World world = make_world();
  for (std::size_t i = 9; i < 40; ++i) world.sites.sites.push_back(world.sites.sites[i % 9]);
  MeasureErrorOptions options = two_looks();
  options.reference = ErrorReference::kKnownPose;
  options.ranges_m = {6.0};
  const std::vector<std::byte> expected = bytes_without_times(*measure_both(world, options));
  std::map<std::size_t, std::vector<std::byte>> parts;
  PassContext ctx;
  ctx.saved_part = [&](const PartName& part) -> std::optional<std::vector<std::byte>> {
    return parts.contains(part.number) ? std::optional(parts[part.number]) : std::nullopt;
  };
  ctx.part_sink = [&](const PartName& part, std::span<const std::byte> bytes) {
    parts[part.number].assign(bytes.begin(), bytes.end());
  };
  const auto run = [&](int reads) {
    const auto store = std::make_shared<LimitedStore>(world.drive.store, reads);
    Drive drive = world.drive;
    drive.store = store;
    const Result<ByFamily<MeasuredError>> measured =
        whole_rows(measure_error(ctx, options, drive, world.trajectory, world.map, world.sites));
    return std::make_pair(measured, store->left());
  };
  EXPECT_FALSE(run(38).first.has_value());
  EXPECT_EQ(parts.size(), 2u) << "two parts of 16 sites are done, the third of 8 is not";
  const auto [resumed, left] = run(100);
  ASSERT_TRUE(resumed.has_value());
  EXPECT_EQ(left, 92) << "only the third part was measured anew";
  EXPECT_EQ(bytes_without_times(*resumed), expected);
  parts[1][parts[1].size() / 2] ^= std::byte{1};
  const auto [repaired, left_after] = run(100);
  ASSERT_TRUE(repaired.has_value());
  EXPECT_EQ(left_after, 84) << "a damaged part is measured anew";
  EXPECT_EQ(bytes_without_times(*repaired), expected);
}

TEST(MeasureError, MakesOnlyThePartsAnewThatAChangeReaches) {
  World world = make_world();
  // The room, and the same drive through it, again 400 m farther on.
  for (std::size_t i = 9; i < 16; ++i) world.sites.sites.push_back(world.sites.sites[i % 9]);
  std::vector<Scan> scans;
  for (std::size_t i = 0; i < 9; ++i) scans.push_back(*world.drive.store->read(i));
  NdtMap far = ndt_from_points(
      transformed(Pose(Eigen::Translation3d(400.0, 0.0, 0.0)), room_points(1, 30000, 0.02)),
      MapFrame{}, BuildNdtOptions{}, 1);
  world.map.nds.insert(world.map.nds.end(), far.nds.begin(), far.nds.end());
  for (std::size_t i = 0; i < 9; ++i) {
    scans.push_back(scans[i]);
    ScanInfo info = world.drive.scans[i];
    info.recording_index += 100;
    world.drive.scans.push_back(info);
    TrajectoryPose pose = world.trajectory.poses[i];
    pose.recording_index += 100;
    pose.T_map_vehicle.translation().x() += 400.0;
    world.trajectory.poses.push_back(pose);
    Site site = world.sites.sites[i];
    site.T_map_vehicle.translation().x() += 400.0;
    world.sites.sites.push_back(site);
  }
  world.drive.store = memory_scan_store(scans);
  MeasureErrorOptions options = two_ranges();
  options.reference = ErrorReference::kKnownPose;
  options.ranges_m = {6.0};
  KeptParts kept;
  const auto run = [&] {
    PassContext ctx = kept.context();
    MeasuredError measured = *of_ranges(whole_rows(
        measure_error(ctx, options, world.drive, world.trajectory, world.map, world.sites)));
    for (ErrorRow& row : measured.rows) forget_times(row);
    return to_bytes(measured);
  };
  (void)run();
  ASSERT_EQ(kept.count(), 2U);
  ASSERT_EQ(kept.made().size(), 2U);
  Nd& last = world.map.nds.back();
  last.covariance_m2 *= 2.0;
  decompose(last);
  const std::vector<std::byte> changed = run();
  EXPECT_EQ(kept.made(), std::set<std::size_t>{1}) << "the room that it lies in";
  kept.forget();
  EXPECT_EQ(changed, run());
  scans[2].points_m.pop_back();
  world.drive.store = memory_scan_store(scans);
  (void)run();
  EXPECT_EQ(kept.made(), std::set<std::size_t>{0});
  world.trajectory.poses[12].T_map_vehicle.translation().x() += 0.01;
  (void)run();
  EXPECT_EQ(kept.made(), std::set<std::size_t>{1});
}

TEST(MeasureError, MeasuresLooksThatTakeASampleBesideTheRanges) {
  const World world = make_world();
  const Result<MeasuredError> ranges = measure(world, two_ranges());
  const ByFamily<MeasuredError> both = value_of(measure_both(world, two_looks()));
  ASSERT_TRUE(validate(both).has_value());
  ASSERT_TRUE(both.samples.has_value());
  const MeasuredError& samples = *both.samples;
  EXPECT_EQ(samples.looks, two_looks().looks);
  EXPECT_EQ(samples.scan_of_site, both.ranges.scan_of_site);
  for (std::size_t site = 0; site < both.ranges.scan_of_site.size(); ++site) {
    for (std::size_t range = 0; range < both.ranges.looks.size(); ++range) {
      EXPECT_EQ(both.ranges.row(site, range).mean_m, ranges->row(site, range).mean_m)
          << "a range is what it is, whatever looks stand beside it";
    }
    EXPECT_EQ(samples.row(site, 0).point_count, 100U);
    EXPECT_LT(samples.row(site, 0).mean_m, 0.1) << "the room is seen whole";
    EXPECT_LT(samples.row(site, 0).mean_work, both.ranges.row(site, 1).mean_work);
  }
}

TEST(MeasureError, MeasuresLooksAlikeForAnyNumberOfThreads) {
  const World world = make_world();
  EXPECT_EQ(bytes_without_times(*measure_both(world, two_looks(), 1)),
            bytes_without_times(*measure_both(world, two_looks(), 3)));
}

TEST(MeasureError, TakesEveryReturnWithinARangeWhereThePapersProtocolIsAsked) {
  const World world = make_world();
  MeasureErrorOptions paper = two_ranges();
  paper.every_return = true;
  const MeasuredError measured = value_of(measure(world, paper));
  const Result<MeasuredError> thinned = measure(world, two_ranges());
  EXPECT_GE(measured.row(0, 0).point_count, thinned->row(0, 0).point_count);
  const double range_m = measured.looks.front().range_m;
  const std::size_t scan = static_cast<std::size_t>(measured.scan_of_site[0]) / 2;
  const std::vector<Eigen::Vector3d> near = crop(world.drive.store->read(scan)->points_m, range_m);
  EXPECT_EQ(measured.row(0, 0).point_count, voxel_subsample(near, 1.0).size());
  EXPECT_FALSE(measured.matching.localizer == thinned->matching.localizer)
      << "a map of the one is none for the other";
}

TEST(MeasureError, TheAnnealedLocalizerEndsNearerFromTheSameStarts) {
  const World world = make_world();
  MeasureErrorOptions options = two_ranges();
  options.reference = ErrorReference::kKnownPose;
  options.localizer = LocalizerKind::kPlain;
  const Result<MeasuredError> plain = measure(world, options);
  options.localizer = LocalizerKind::kAnnealed;
  const Result<MeasuredError> annealed = measure(world, options);
  ASSERT_TRUE(plain.has_value() && annealed.has_value());
  double plain_m = 0.0;
  double annealed_m = 0.0;
  for (std::size_t i = 0; i < plain->rows.size(); ++i) {
    plain_m += plain->rows[i].mean_m;
    annealed_m += annealed->rows[i].mean_m;
  }
  EXPECT_LT(annealed_m, plain_m);
}

TEST(MeasureError, NamesTheLocalizerAndWhatItsNameLeavesOpen) {
  const MeasuredError measured = value_of(measure(make_world(), two_ranges()));
  EXPECT_EQ(to_text(measured.matching.localizer),
            "searching v3 (cell_m=2, coarse_cells=1, leaf_m=1)");
}

TEST(MeasureError, LocalizesByPclAtEveryTenthSiteFromThreeStartsForAnyNumberOfThreads) {
  if (!has_pcl_ndt()) GTEST_SKIP() << "built without PCL";
  World world = make_world();
  // Two more rounds over the same places: 27 sites.
  const std::vector<Site> once = world.sites.sites;
  for (int round = 0; round < 2; ++round) {
    world.sites.sites.insert(world.sites.sites.end(), once.begin(), once.end());
  }
  MeasureErrorOptions options = two_ranges();
  options.localizer = LocalizerKind::kPclNdt;
  options.reference = ErrorReference::kKnownPose;
  const Result<MeasuredError> one = measure(world, options, 1);
  const Result<MeasuredError> three = measure(world, options, 3);
  ASSERT_TRUE(one.has_value() && three.has_value());
  const auto bytes_without_times = [](MeasuredError measured) {
    for (ErrorRow& row : measured.rows) forget_times(row);
    return to_bytes(measured);
  };
  EXPECT_EQ(bytes_without_times(*one), bytes_without_times(*three));
  EXPECT_EQ(one->matching.localizer.name, "pcl-ndt");
  EXPECT_EQ(one->matching.site_step, 10u);
  EXPECT_EQ(one->offsets.size(), 3u);
  for (std::size_t site = 0; site < one->scan_of_site.size(); ++site) {
    EXPECT_EQ(one->scan_of_site[site] >= 0, site % 10 == 0) << site;
  }
  EXPECT_GT(one->row(0, 1).point_count, one->row(0, 0).point_count);
  EXPECT_GT(one->row(0, 1).mean_iterations, 1.0);
  EXPECT_LT(one->row(0, 1).mean_m, 0.25) << "from 0.25 m off and nearer";
}

void expect_refused(const World& world, ErrorCode code) {
  const Error error = failure_of(measure(world, two_ranges()));
  EXPECT_EQ(error.code, code) << to_string(error);
}

TEST(MeasureError, OfALaterDriveThatIsNowhereNearIsEmpty) {
  World world = make_world();
  for (TrajectoryPose& pose : world.trajectory.poses) pose.T_map_vehicle.translation().x() += 500.0;
  MeasureErrorOptions options = two_ranges();
  options.may_be_elsewhere = true;
  PassContext ctx;
  const MeasuredError measured = value_of(of_ranges(whole_rows(
      measure_error(ctx, options, world.drive, world.trajectory, world.map, world.sites))));
  ASSERT_TRUE(validate(measured).has_value());
  EXPECT_EQ(measured.scan_of_site,
            std::vector<std::int64_t>(world.sites.sites.size(), std::int64_t{-1}));
}

TEST(MeasureError, RefusesADriveThatIsNowhereNear) {
  World world = make_world();
  for (TrajectoryPose& pose : world.trajectory.poses) pose.T_map_vehicle.translation().x() += 500.0;
  expect_refused(world, ErrorCode::kNoOverlap);
}

TEST(MeasureError, RefusesAMapWithoutAnyNd) {
  World world = make_world();
  world.map.nds.clear();
  expect_refused(world, ErrorCode::kEmptyMap);
}

TEST(MeasureError, RefusesATrajectoryOfAnotherDrive) {
  World world = make_world();
  world.trajectory.poses.pop_back();
  expect_refused(world, ErrorCode::kMismatchedInputs);
}

TEST(MeasureError, RefusesSitesInAnotherFrameThanTheMap) {
  World world = make_world();
  world.sites.frame.origin_world_m.x() = 64.0;
  expect_refused(world, ErrorCode::kMismatchedInputs);
}

class UnreadableStore : public ScanStore {
 public:
  Result<Scan> read(std::size_t) const override {
    return Error{ErrorCode::kTruncatedScan, "cut short", "0001.pcd"};
  }
};

TEST(MeasureError, PassesOnThatAScanCannotBeRead) {
  World world = make_world();
  world.drive.store = std::make_shared<UnreadableStore>();
  expect_refused(world, ErrorCode::kTruncatedScan);
}

}  // namespace
}  // namespace sightline
