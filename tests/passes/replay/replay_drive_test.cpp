#include "passes/replay/replay_drive.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <utility>

#include "formats/base/files/atomic_file.h"
#include "formats/map/map_writer.h"
#include "passes/map/build_ndt.h"
#include "tests/formats/map/random_map.h"
#include "tests/support/box_world.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr std::size_t kScans = 44;

// Of the sensor and of places along the street, for every return within 30 or 50 m.
std::string write_map() {
  CompiledMap map = random_map(
      {.seed = 1, .site_count = 36, .run_count = 1, .ranges_m = {30.0, 50.0}, .looks = {}});
  const BoxWorld world = random_street(20);
  std::vector<Eigen::Vector3d> points_m;
  for (int i = 0; i < 36; ++i) {
    const Pose T_map_lidar = lidar_at(i - 4.0, 0.0, 0.0);
    map.sites.sites[static_cast<std::size_t>(i)].p_map_m = T_map_lidar.translation();
    for (const Eigen::Vector3d& point_m : scan_world(world, T_map_lidar, 1.0).points_m) {
      points_m.push_back(T_map_lidar * point_m);
    }
  }
  map.ndt = ndt_from_points(points_m, map.ndt.frame, {}, 1);
  map.measurement.localizer.name = "searching";
  map.sensor.T_vehicle_lidar.translation() = Eigen::Vector3d(0.0, 0.0, 2.0);
  const std::filesystem::path path = scratch_folder() / "street.slmap";
  EXPECT_TRUE(write_file_atomically(path, encode_map(map), IfExists::kReplace));
  return path.string();
}

JoinedMaps& opened() {
  static JoinedMaps maps = value_of(JoinedMaps::open({write_map()}, {}));
  return maps;
}

Pose in_world(const Pose& T_map) {
  MapFrame frame;
  frame.origin_world_m =
      Eigen::Map<const Eigen::Vector3d>(opened().reader(0).info().origin_world_m.data());
  return rebase(T_map, frame, MapFrame{});
}

TestDrive drive_in(std::uint64_t street) {
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < kScans; ++i) {
    poses.push_back(pose_at(0.5 + 0.4 * static_cast<double>(i), -0.3, 0.02));
  }
  return drive_through(random_street(street), poses, 1.0);
}

const TestDrive& second_drive() {
  static const TestDrive kDrive = drive_in(20);
  return kDrive;
}
const TestDrive& drive_elsewhere() {
  // Across another street, so that nothing lies where the map has it.
  static const TestDrive kDrive = [] {
    const std::vector<Pose> poses(kScans, pose_at(20.0, 0.0, 1.2));
    return drive_through(random_street(77), poses, 1.0);
  }();
  return kDrive;
}

// Reads another drive's scan where `is_other`, an error where `is_bad`.
class MixedStore : public ScanStore {
 public:
  using Which = std::function<bool(std::size_t)>;
  MixedStore(Which is_other, Which is_bad)
      : is_other_(std::move(is_other)), is_bad_(std::move(is_bad)) {}
  Result<Scan> read(std::size_t index) const override {
    if (is_bad_(index)) return Error{ErrorCode::kTruncatedScan, "cut", "scan.pcd"};
    return (is_other_(index) ? drive_elsewhere() : second_drive()).drive.store->read(index);
  }

 private:
  Which is_other_;
  Which is_bad_;
};

bool never(std::size_t /*scan*/) { return false; }

std::vector<ListedScan> listed(bool has_poses) {
  std::vector<ListedScan> scans;
  for (const TrajectoryPose& pose : second_drive().truth.poses) {
    scans.push_back({pose.stamp_ns, "scan " + std::to_string(scans.size()), std::nullopt});
    if (has_poses) scans.back().T_world_vehicle = in_world(pose.T_map_vehicle);
  }
  return scans;
}

Pose true_start() { return in_world(second_drive().truth.poses.front().T_map_vehicle); }

struct Request {
  bool has_poses = false;
  std::optional<Pose> start = std::nullopt;
  bool is_from_nothing = false;
  MixedStore::Which is_other = never;
  MixedStore::Which is_bad = never;
};

Result<ReplayedDrive> replay(const Request& request, const PassContext& ctx) {
  const MixedStore store(request.is_other, request.is_bad);
  const std::vector<ListedScan> scans = listed(request.has_poses);
  ReplayOptions options;
  options.T_world_start = request.start;
  options.starts_from_nothing = request.is_from_nothing;
  return replay_drive(ctx, options, {opened(), second_drive().drive.sensor, store, scans});
}
Result<ReplayedDrive> replay(const Request& request) { return replay(request, PassContext{}); }

double error_m(const ReplayedDrive& drive, std::size_t scan) {
  const Pose truth = in_world(second_drive().truth.poses[scan].T_map_vehicle);
  return (drive.scans[scan].T_world_vehicle.translation() - truth.translation()).norm();
}

void expect_localized(const ReplayedDrive& drive, std::size_t first, std::size_t end) {
  for (std::size_t i = first; i < end; ++i) {
    EXPECT_EQ(drive.scans[i].state, ScanState::kLocalized) << i;
    // The speed is not known at the second scan.
    EXPECT_LT(error_m(drive, i), i == 1 ? 0.2 : 0.05) << i;
  }
}

TEST(ReplayDrive, LocalizesEveryScanFromAStartThatIsHalfAMetreOff) {
  Pose start = true_start();
  start.translation().x() += 0.4;
  start.translation().y() -= 0.3;
  const ReplayedDrive drive = value_of(replay({.start = start}));
  ASSERT_EQ(drive.scans.size(), kScans);
  expect_localized(drive, 0, kScans);
  EXPECT_EQ(drive.lost_count, 0U);
  EXPECT_TRUE(drive.scans[0].begins);
  EXPECT_FALSE(drive.scans[1].begins);
  EXPECT_GT(drive.scans[5].point_count, 100U);
  EXPECT_GT(drive.scans[5].covariance(0, 0), 0.0);
  EXPECT_EQ(drive.scans[5].look.return_count, 0U) << "this map names ranges alone";
}

TEST(ReplayDrive, FindsTheVehicleUpToThreeMetresFromTheStart) {
  Pose start = true_start();
  start.translation() += Eigen::Vector3d(2.0, -1.5, 0.0);
  expect_localized(value_of(replay({.start = start})), 0, kScans);
}

TEST(ReplayDrive, StartsFromThePosesOfTheRecordingWhereNoneIsGiven) {
  expect_localized(value_of(replay({.has_poses = true})), 0, kScans);
}

TEST(ReplayDrive, SearchesTheWholeMapWhereNoStartIsKnown) {
  const ReplayedDrive drive = value_of(replay({}));
  expect_localized(drive, 0, kScans);
  EXPECT_TRUE(drive.scans[0].begins);
}

TEST(ReplayDrive, UsesNoPoseOfTheRecordingWhereItStartsFromNothing) {
  const ReplayedDrive drive = value_of(replay({.has_poses = true, .is_from_nothing = true}));
  const ReplayedDrive without = value_of(replay({}));
  for (std::size_t i = 0; i < kScans; ++i) {
    EXPECT_EQ(error_m(drive, i), error_m(without, i)) << i;
  }
}

TEST(ReplayDrive, FindsNoPlaceForADriveOfAnotherStreet) {
  const Result<ReplayedDrive> drive = replay({.is_other = [](std::size_t) { return true; }});
  ASSERT_FALSE(drive);
  EXPECT_EQ(drive.error().code, ErrorCode::kNoOverlap);
  EXPECT_THAT(drive.error().message,
              HasSubstr("none of the first 44 scans fits one place of the map"));
  EXPECT_THAT(drive.error().message, HasSubstr("--start X Y Z YAW"));
}

TEST(ReplayDrive, FindsALostVehicleInTheWholeMapWithoutPoses) {
  const auto is_other = [](std::size_t scan) { return scan >= 12 && scan < 30; };
  const ReplayedDrive drive = value_of(replay({.is_other = is_other}));
  EXPECT_EQ(drive.scans[29].state, ScanState::kLost);
  std::size_t found = 30;
  while (found < kScans && drive.scans[found].state != ScanState::kLocalized) ++found;
  EXPECT_LE(found, 35U) << "every fifth scan of a lost vehicle is searched for";
  EXPECT_TRUE(drive.scans[found].begins);
  EXPECT_LT(error_m(drive, found), 0.05);
}

TEST(ReplayDrive, IsRefusedInAnotherStreetAndBesideTheMap) {
  const Result<ReplayedDrive> elsewhere =
      replay({.start = true_start(), .is_other = [](std::size_t) { return true; }});
  ASSERT_FALSE(elsewhere);
  EXPECT_EQ(elsewhere.error().code, ErrorCode::kNoOverlap);
  EXPECT_THAT(elsewhere.error().message, HasSubstr("none of the first 20 scans"));
  Pose far = true_start();
  far.translation().x() += 5000.0;
  const Result<ReplayedDrive> beside = replay({.start = far});
  ASSERT_FALSE(beside);
  EXPECT_EQ(beside.error().code, ErrorCode::kNoOverlap);
}

TEST(ReplayDrive, SaysWhereItIsLostAndFindsItsWayBack) {
  const auto is_other = [](std::size_t scan) { return scan >= 12 && scan < 28; };
  const ReplayedDrive drive = value_of(replay({.has_poses = true, .is_other = is_other}));
  expect_localized(drive, 0, 12);
  std::size_t first_lost = 12;
  while (first_lost < kScans && drive.scans[first_lost].state != ScanState::kLost) ++first_lost;
  EXPECT_GE(first_lost, 14U) << "one scan that contradicts the map is no loss";
  EXPECT_LE(first_lost, 24U);
  EXPECT_TRUE(drive.scans[first_lost - 1].is_in_doubt);
  for (std::size_t i = first_lost; i < 28; ++i) {
    EXPECT_EQ(drive.scans[i].state, ScanState::kLost) << i;
  }
  EXPECT_TRUE(drive.scans[28].begins);
  expect_localized(drive, 28, kScans);
  EXPECT_EQ(drive.lost_count, 1U);
}

TEST(ReplayDrive, LeavesOutAFewScansThatCannotBeRead) {
  TestContext ctx;
  const ReplayedDrive drive = value_of(replay(
      {.start = true_start(), .is_bad = [](std::size_t scan) { return scan % 30 == 7; }}, ctx));
  EXPECT_EQ(drive.scans[7].state, ScanState::kSkipped);
  EXPECT_EQ(drive.scans[37].state, ScanState::kSkipped);
  expect_localized(drive, 8, 37);
  expect_localized(drive, 38, kScans);
  EXPECT_THAT(ctx.warnings, ElementsAre(HasSubstr("2 of 44 scans cannot be read")));
  const Result<ReplayedDrive> many =
      replay({.start = true_start(), .is_bad = [](std::size_t scan) { return scan % 10 == 7; }});
  ASSERT_FALSE(many);
  EXPECT_EQ(many.error().code, ErrorCode::kTruncatedScan);
}

TEST(ReplayDrive, FindsTheSameWithAnyNumberOfThreads) {
  const ReplayedDrive one = value_of(replay({.start = true_start()}, TestContext(1)));
  const ReplayedDrive four = value_of(replay({.start = true_start()}, TestContext(4)));
  for (std::size_t i = 0; i < kScans; ++i) {
    EXPECT_TRUE(one.scans[i].T_world_vehicle.matrix() == four.scans[i].T_world_vehicle.matrix());
    EXPECT_TRUE(one.scans[i].covariance == four.scans[i].covariance);
  }
}

}  // namespace
}  // namespace sightline
