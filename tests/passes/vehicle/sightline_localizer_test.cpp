#include "passes/vehicle/sightline_localizer.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <thread>
#include <vector>

#include "formats/foreign/clouds/pcd_writer.h"
#include "formats/map/map_reader.h"
#include "formats/reader/protection_table.h"
#include "passes/matching/match_score.h"
#include "tests/passes/vehicle/localized_room.h"

namespace sightline {
namespace {

TEST(SightlineLocalizer, TakesFloatsAndDoublesAndLeavesOutWhatIsNoReturn) {
  const Opened opened(written_room("searching"));
  const Scan scan = float_scan(9, 3000);
  struct Wide {  // as a driver's message: more than x, y and z
    float x, y, z, intensity;
    std::uint16_t ring;
  };
  std::vector<Wide> wide;
  for (const Eigen::Vector3d& p : scan.points_m) {
    const Eigen::Vector3f f = p.cast<float>();
    wide.push_back({f.x(), f.y(), f.z(), 7.0F, 3});
    if (wide.size() % 7 == 0) wide.push_back({NAN, f.y(), f.z(), 0.0F, 0});
    if (wide.size() % 11 == 0) wide.push_back({0.0F, 0.0F, 0.0F, 0.0F, 0});
  }
  const sightline_points doubles = points_of(scan);
  const sightline_points floats = {wide.data(), wide.size(), sizeof(Wide), 0};
  const MapFrame frame = read_map(written_room("searching"))->ndt.frame;
  const PoseRows start = world_rows(Pose::Identity(), frame);
  for (const Look& look : kLooks) {
    const sightline_look wanted = c_look(look);
    sightline_match a, b;
    ASSERT_EQ(
        sightline_localizer_match(opened.localizer, &doubles, start.data(), &wanted, nullptr, &a),
        0);
    ASSERT_EQ(
        sightline_localizer_match(opened.localizer, &floats, start.data(), &wanted, nullptr, &b),
        0);
    EXPECT_EQ(a.dropped_count, 0u);
    EXPECT_EQ(b.dropped_count, wide.size() - scan.points_m.size());
    b.dropped_count = 0;
    EXPECT_EQ(bytes_of(a), bytes_of(b));
  }
}

TEST(SightlineLocalizer, AnswersAlikeFromManyThreads) {
  const std::string path = written_room("searching");
  const Opened opened(path);
  const MapFrame frame = read_map(path)->ndt.frame;
  const Scan scan = float_scan(9, 3000);
  const sightline_points points = points_of(scan);
  Random random(8);
  std::vector<PoseRows> starts;
  for (int i = 0; i < 40; ++i) starts.push_back(world_rows(random_start(random), frame));
  const auto matches = [&] {
    std::vector<sightline_match> found;
    for (const PoseRows& start : starts) {
      const sightline_look look = c_look(kLooks[found.size() % std::size(kLooks)]);
      sightline_match match;
      sightline_localizer_match(opened.localizer, &points, start.data(), &look, nullptr, &match);
      found.push_back(match);
    }
    return found;
  };
  const std::vector<sightline_match> expected = matches();
  std::vector<std::vector<sightline_match>> found(3);
  {
    std::vector<std::jthread> threads;
    for (std::vector<sightline_match>& of_thread : found) {
      threads.emplace_back([&] { of_thread = matches(); });
    }
  }
  for (const std::vector<sightline_match>& of_thread : found) {
    ASSERT_EQ(of_thread.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_EQ(bytes_of(of_thread[i]), bytes_of(expected[i]));
    }
  }
}

TEST(SightlineLocalizer, TellsWhatItCannotOpen) {
  const std::string folder = scratch_folder().string();
  EXPECT_EQ(Opened(folder + "/none.pcd").code, static_cast<int>(ErrorCode::kFileNotFound));
  EXPECT_EQ(Opened(folder + "/none.slmap").code, static_cast<int>(ErrorCode::kFileNotFound));
  const std::string damaged = folder + "/damaged.slmap";
  ASSERT_TRUE(write_file_atomically(damaged, std::as_bytes(std::span("no map at all")),
                                    IfExists::kReplace));
  const Opened no_map(damaged);
  EXPECT_EQ(no_map.localizer, nullptr);
  EXPECT_NE(no_map.code, 0);
  EXPECT_NE(no_map.message.find("damaged.slmap"), std::string::npos) << no_map.message;
  const PointXyzi few[] = {{1, 2, 3, 0}, {2, 2, 3, 0}};
  ASSERT_TRUE(write_pcd_binary(folder + "/few.pcd", few, IfExists::kReplace));
  const Opened thin(folder + "/few.pcd");
  EXPECT_EQ(thin.code, static_cast<int>(ErrorCode::kEmptyMap)) << thin.message;
  const PointXyzi far[] = {{1, 2, 3, 0}, {3e9F, 2, 3, 0}};
  ASSERT_TRUE(write_pcd_binary(folder + "/far.pcd", far, IfExists::kReplace));
  EXPECT_EQ(Opened(folder + "/far.pcd").code, static_cast<int>(ErrorCode::kUnsupportedFormat));
  sightline_localizer_options options{};
  options.cell_m = -1.0;
  EXPECT_EQ(Opened(folder + "/few.pcd", &options).code, static_cast<int>(ErrorCode::kBadValue));
  options = {};
  const double no_pose[12] = {};
  options.T_vehicle_sensor = no_pose;
  EXPECT_EQ(Opened(written_room("searching"), &options).code,
            static_cast<int>(ErrorCode::kBadValue));
  sightline_localizer_close(nullptr);
}

// The score where a match ended is that of the match; a wrong pose has less.
TEST(SightlineLocalizer, ScoresAPoseWithoutMovingIt) {
  const std::string path = written_room("searching");
  const Opened opened(path);
  const MapFrame frame = read_map(path)->ndt.frame;
  const Scan scan = float_scan(9, 3000);
  const sightline_points points = points_of(scan);
  const PoseRows start = world_rows(Pose::Identity(), frame);
  for (const Look& chosen : kLooks) {
    const sightline_look look = c_look(chosen);
    sightline_match found, scored, wrong;
    ASSERT_EQ(
        sightline_localizer_match(opened.localizer, &points, start.data(), &look, nullptr, &found),
        0);
    ASSERT_EQ(
        sightline_localizer_score(opened.localizer, &points, found.T_world_vehicle, &look, &scored),
        0);
    EXPECT_EQ(scored.stop, SIGHTLINE_CONVERGED);
    // A look by normals takes other points from another start.
    const double share = chosen.is_by_normals ? 0.1 : 0.01;
    EXPECT_NEAR(scored.score, found.score, share * found.score);
    EXPECT_NEAR(scored.nearest_voxel_likelihood, found.nearest_voxel_likelihood, 0.1);
    EXPECT_TRUE(std::ranges::equal(scored.T_world_vehicle, found.T_world_vehicle));
    PoseRows off = start;
    off(0, 3) += 1.5;
    ASSERT_EQ(sightline_localizer_score(opened.localizer, &points, off.data(), &look, &wrong), 0);
    EXPECT_LT(wrong.nearest_voxel_likelihood, 0.9 * scored.nearest_voxel_likelihood);
  }
}

TEST(SightlineLocalizer, ScoresNothingFarFromTheMapAndRefusesBadArguments) {
  const Opened opened(written_room("searching"));
  const Scan scan = float_scan(9, 100);
  const sightline_points points = points_of(scan);
  const sightline_look look = c_look(kLooks[1]);
  PoseRows pose = Pose::Identity().affine();
  sightline_match match;
  EXPECT_EQ(sightline_localizer_score(opened.localizer, &points, pose.data(), &look, &match), 0);
  EXPECT_EQ(match.stop, SIGHTLINE_NO_OVERLAP);
  EXPECT_EQ(match.score, 0.0);
  const int bad_argument = static_cast<int>(ErrorCode::kBadArgument);
  EXPECT_EQ(sightline_localizer_score(nullptr, &points, pose.data(), &look, &match), bad_argument);
  EXPECT_EQ(sightline_localizer_score(opened.localizer, &points, pose.data(), &look, nullptr),
            bad_argument);
  pose(1, 1) = 2.0;
  EXPECT_EQ(sightline_localizer_score(opened.localizer, &points, pose.data(), &look, &match),
            bad_argument);
}

TEST(SightlineLocalizer, RefusesWhatIsNoStartAndNoLook) {
  const Opened opened(written_room("searching"));
  const Scan scan = float_scan(9, 3000);
  const sightline_points points = points_of(scan);
  const PoseRows good = Pose::Identity().affine();
  const auto code = [&](const PoseRows& start, const sightline_look& look) {
    sightline_match match;
    const int result =
        sightline_localizer_match(opened.localizer, &points, start.data(), &look, nullptr, &match);
    if (result != 0) {
      EXPECT_EQ(std::string_view(reinterpret_cast<const char*>(match.T_world_vehicle), 96),
                std::string_view(reinterpret_cast<const char*>(start.data()), 96));
      EXPECT_EQ(match.stop, SIGHTLINE_NO_POINTS);
    }
    return result;
  };
  const sightline_look look = c_look(kLooks[1]);
  const int bad_argument = static_cast<int>(ErrorCode::kBadArgument);
  // Nothing of the map is there, which is no error.
  EXPECT_EQ(code(good, look), 0);
  for (const double wrong : {2.0, std::numeric_limits<double>::quiet_NaN()}) {
    PoseRows start = good;
    start(1, 1) = wrong;
    EXPECT_EQ(code(start, look), bad_argument);
  }
  for (const double away_m : {1e12, -1e300, std::numeric_limits<double>::infinity()}) {
    PoseRows start = good;
    start(2, 3) = away_m;
    EXPECT_EQ(code(start, look), bad_argument);
  }
  for (const double range_m : {0.0, -1.0, 1e9, std::numeric_limits<double>::quiet_NaN()}) {
    sightline_look wrong = look;
    wrong.range_m = range_m;
    EXPECT_EQ(code(good, wrong), bad_argument);
  }
  const sightline_points none = {nullptr, 0, 12, 0};
  sightline_match match;
  EXPECT_EQ(sightline_localizer_match(opened.localizer, &none, good.data(), &look, nullptr, &match),
            0);
  EXPECT_EQ(match.stop, SIGHTLINE_NO_POINTS);
  const sightline_points too_many = {nullptr, std::size_t{1} << 31, 12, 0};
  EXPECT_EQ(
      sightline_localizer_match(opened.localizer, &too_many, good.data(), &look, nullptr, &match),
      bad_argument);
}

TEST(SightlineLocalizer, NeverSaysConvergedOfFewerThanSixPoints) {
  const std::string path = written_room("searching");
  const Opened opened(path);
  const PoseRows start = world_rows(Pose::Identity(), read_map(path)->ndt.frame);
  const Scan scan = float_scan(9, 3000);
  const sightline_look look = c_look(every_return(30.0));
  for (const std::size_t count : {1U, 2U, 3U, 4U, 5U, 6U, 3000U}) {
    sightline_points points = points_of(scan);
    points.count = count;
    sightline_match match;
    ASSERT_EQ(
        sightline_localizer_match(opened.localizer, &points, start.data(), &look, nullptr, &match),
        0);
    EXPECT_EQ(match.stop == SIGHTLINE_CONVERGED, count == 3000) << count << " points";
  }
}

sightline_match match_of(const std::vector<Eigen::Vector3d>& points_m, const Look& taken) {
  const std::string path = written_room("searching");
  const Opened opened(path);
  const PoseRows start = world_rows(Pose::Identity(), read_map(path)->ndt.frame);
  Scan scan;
  scan.points_m = points_m;
  const sightline_points points = points_of(scan);
  const sightline_look look = c_look(taken);
  sightline_match match;
  EXPECT_EQ(
      sightline_localizer_match(opened.localizer, &points, start.data(), &look, nullptr, &match),
      0);
  return match;
}

// Returns from one cell hold at most two motions.
TEST(SightlineLocalizer, NeverSaysConvergedWhereAMotionIsEntirelyFree) {
  std::vector<Eigen::Vector3d> of_one_cell_m;
  for (int row = 0; row < 8; ++row) {
    for (int column = 0; column < 8; ++column) {
      const double x = 2.3 + 0.2 * column;
      of_one_cell_m.emplace_back(x, 0.3 + 0.2 * row, -2.0 + 0.02 * x);
    }
  }
  for (const Look& look : kLooks) {
    const sightline_match match = match_of(of_one_cell_m, look);
    EXPECT_GT(match.scored_points, 6U);
    EXPECT_NE(match.stop, SIGHTLINE_CONVERGED);
  }
}

TEST(SightlineLocalizer, NamesTheMotionsThatTheFloorAloneDoesNotHold) {
  Scan scan = float_scan(9, 3000);
  std::erase_if(scan.points_m, [](const Eigen::Vector3d& p_m) {
    return p_m.z() > -1.85 || p_m.head<2>().norm() > 4.0;  // the floor, away from the walls
  });
  const sightline_match match = match_of(scan.points_m, every_return(30.0));
  EXPECT_GT(match.scored_points, 100U);
  constexpr std::uint32_t kFree = SIGHTLINE_WEAK_FORWARD | SIGHTLINE_WEAK_LEFT | SIGHTLINE_WEAK_YAW;
  EXPECT_EQ(match.weak & kFree, kFree);
}

// A match in the room, and what is known of its start.
struct RoomMatch {
  explicit RoomMatch(const sightline_match_options* options = nullptr) {
    const std::string path = written_room("searching");
    const Opened opened(path);
    const PoseRows start = world_rows(Pose::Identity(), read_map(path)->ndt.frame);
    const Scan scan = float_scan(9, 3000);
    const sightline_points points = points_of(scan);
    const sightline_look look = c_look(kLooks[1]);
    code =
        sightline_localizer_match(opened.localizer, &points, start.data(), &look, options, &match);
  }
  [[nodiscard]] Matrix6d information() const {
    return Eigen::Map<const Matrix6d>(match.information);
  }
  [[nodiscard]] Matrix6d covariance() const { return Eigen::Map<const Matrix6d>(match.covariance); }

  sightline_match match{};
  int code = 0;
};

TEST(SightlineLocalizer, ReturnsTheCovarianceOfItsPoseGivenTheStarts) {
  const RoomMatch unknown;
  ASSERT_EQ(unknown.code, 0);
  EXPECT_EQ(unknown.match.weak, 0u);
  EXPECT_EQ(unknown.information(), unknown.information().transpose());
  // A room holds every motion, so the start's adds little.
  EXPECT_LT((unknown.covariance() * unknown.information() - Matrix6d::Identity()).norm(), 1e-3);
  for (int i = 0; i < 3; ++i) EXPECT_LT(std::sqrt(unknown.covariance()(i, i)), 0.05);
  const Matrix6d small = 1e-6 * Matrix6d::Identity();
  sightline_match_options options{};
  options.start_covariance = small.data();
  const RoomMatch known(&options);
  EXPECT_EQ(known.information(), unknown.information());
  for (int i = 0; i < 6; ++i) EXPECT_LT(known.covariance()(i, i), unknown.covariance()(i, i));
}

TEST(SightlineLocalizer, TakesTheErrorsOfAPlace) {
  const RoomMatch usual;
  sightline_match_options options{};
  options.variance_factor = 4.0;
  options.map_m = 0.2;
  options.map_rad = 0.01;
  const RoomMatch wrong(&options);
  for (int i = 0; i < 3; ++i) {
    EXPECT_GT(std::sqrt(wrong.covariance()(i, i)), 0.19);
    EXPECT_LT(wrong.information()(i, i), usual.information()(i, i));
  }
}

TEST(SightlineLocalizer, RefusesWhatIsNoCovariance) {
  const int bad_argument = static_cast<int>(ErrorCode::kBadArgument);
  Matrix6d matrix = Matrix6d::Identity();
  sightline_match_options options{};
  options.start_covariance = matrix.data();
  EXPECT_EQ(RoomMatch(&options).code, 0);
  matrix(0, 3) = 0.5;
  EXPECT_EQ(RoomMatch(&options).code, bad_argument);
  matrix = -Matrix6d::Identity();
  EXPECT_EQ(RoomMatch(&options).code, bad_argument);
  for (const double wrong : {-1.0, std::numeric_limits<double>::quiet_NaN()}) {
    options = {};
    options.map_m = wrong;
    EXPECT_EQ(RoomMatch(&options).code, bad_argument);
  }
}

// The room's sites are of no kind, so that its row is that of all places.
TEST(SightlineLocalizer, BoundsTheErrorsOfAMatchOfAKnownStart) {
  const Matrix6d small = 1e-4 * Matrix6d::Identity();
  sightline_match_options options{};
  options.start_covariance = small.data();
  const sightline_match known = RoomMatch(&options).match;
  const ProtectionRow& row = protection_row(PlaceGroup::kAny);
  EXPECT_EQ(known.place_kind, 0u);
  EXPECT_EQ(known.protection_blocks, row.block_count);
  for (int i = 0; i < 3; ++i) {
    EXPECT_GT(known.protection_m[i], 0.0);
    EXPECT_LT(known.protection_m[i], row.percent_factors[static_cast<std::size_t>(i)] * 0.011);
  }
  EXPECT_LE(known.protection_yaw_rad, row.percent_factors[3] * 0.011);
  options.protection_risk = 0.001;
  EXPECT_EQ(RoomMatch(&options).match.protection_m[1], kUnavailable);
  options.protection_risk = -1.0;
  EXPECT_EQ(RoomMatch(&options).code, static_cast<int>(ErrorCode::kBadArgument));
}

TEST(SightlineLocalizer, CountsTheRaisedPointsThatTheMapHas) {
  const sightline_match match = RoomMatch().match;
  EXPECT_GT(match.raised_points, 100U) << "the walls of the room";
  EXPECT_GE(match.raised_met, 0.9 * match.raised_points);
  EXPECT_LE(match.raised_met, match.raised_points);
}

TEST(SightlineLocalizer, BoundsNothingThatWasNotCalibrated) {
  EXPECT_EQ(RoomMatch().match.protection_m[0], kUnavailable);  // no covariance of the start
  const Matrix6d small = 1e-4 * Matrix6d::Identity();
  sightline_match_options options{};
  options.start_covariance = small.data();
  options.map_m = 0.1;
  EXPECT_EQ(RoomMatch(&options).match.protection_m[0], kUnavailable);
}

TEST(SightlineMonitor, GivesAnAlarmAfterSeveralDoubtfulMatches) {
  sightline_monitor monitor{};
  sightline_match match{};
  match.integrity = SIGHTLINE_INTEGRITY_DOUBTFUL;
  EXPECT_EQ(sightline_monitor_add(&monitor, &match), SIGHTLINE_INTEGRITY_OK);
  EXPECT_EQ(sightline_monitor_add(&monitor, &match), SIGHTLINE_INTEGRITY_DOUBTFUL);
  sightline_monitor_add(&monitor, &match);
  EXPECT_EQ(sightline_monitor_add(&monitor, &match), SIGHTLINE_INTEGRITY_LOST);
  sightline_monitor elsewhere{};
  sightline_match missed{};
  missed.integrity = SIGHTLINE_INTEGRITY_OK;
  missed.place_kind = 9;  // field
  missed.raised_points = 300;
  EXPECT_EQ(sightline_monitor_add(&elsewhere, &missed), SIGHTLINE_INTEGRITY_DOUBTFUL);
  EXPECT_EQ(elsewhere.raised_points, 300.0);
  EXPECT_EQ(sightline_monitor_add(nullptr, &match), SIGHTLINE_INTEGRITY_UNKNOWN);
  EXPECT_EQ(sightline_monitor_add(&monitor, nullptr), SIGHTLINE_INTEGRITY_UNKNOWN);
}

TEST(SightlineLocalizer, WithoutAMatchTheCovarianceIsTheStarts) {
  const Opened opened(written_room("searching"));
  const sightline_points none = {nullptr, 0, 12, 0};
  const PoseRows start = Pose::Identity().affine();
  const sightline_look look = c_look(kLooks[1]);
  const Matrix6d given = 0.04 * Matrix6d::Identity();
  sightline_match_options options{};
  options.start_covariance = given.data();
  sightline_match match;
  ASSERT_EQ(
      sightline_localizer_match(opened.localizer, &none, start.data(), &look, &options, &match), 0);
  EXPECT_EQ(Matrix6d(Eigen::Map<const Matrix6d>(match.covariance)), given);
  EXPECT_TRUE(Matrix6d(Eigen::Map<const Matrix6d>(match.information)).isZero(0.0));
  EXPECT_EQ(match.weak, 63u);
}

TEST(SightlineLocalizer, EveryPointerMayBeNull) {
  constexpr int kBadArgument = 1001;
  const std::string path = written_room("searching");
  const Opened opened(path);
  const Scan scan = float_scan(9, 100);
  const sightline_points points = points_of(scan);
  const PoseRows start = world_rows(Pose::Identity(), read_map(path)->ndt.frame);
  const sightline_look look = c_look(kLooks[0]);
  sightline_look_plan plan = {};
  plan.first = plan.second = look;
  plan.has_second = 1;
  sightline_match match;
  sightline_localizer* none = nullptr;
  EXPECT_EQ(sightline_localizer_open(nullptr, nullptr, &none, nullptr, 0), kBadArgument);
  EXPECT_EQ(sightline_localizer_open(path.c_str(), nullptr, nullptr, nullptr, 0), kBadArgument);
  sightline_localizer_info info;
  sightline_localizer_get_info(opened.localizer, nullptr);
  sightline_localizer_get_info(nullptr, &info);
  EXPECT_STREQ(info.kernel, "");
  // Each of the five pointers in turn; the last round has none missing.
  for (int missing = 0; missing < 6; ++missing) {
    const sightline_localizer* localizer = missing == 0 ? nullptr : opened.localizer;
    const sightline_points* from = missing == 1 ? nullptr : &points;
    const double* T_world_start = missing == 2 ? nullptr : start.data();
    sightline_match* to = missing == 4 ? nullptr : &match;
    const int expected = missing == 5 ? 0 : kBadArgument;
    EXPECT_EQ(sightline_localizer_match(localizer, from, T_world_start,
                                        missing == 3 ? nullptr : &look, nullptr, to),
              expected)
        << missing;
    EXPECT_EQ(sightline_localizer_match_plan(localizer, from, T_world_start,
                                             missing == 3 ? nullptr : &plan, nullptr, to),
              expected)
        << missing;
  }
  sightline_localizer_close(nullptr);
}

}  // namespace
}  // namespace sightline
