#include "compiler/views/exports/octomap.h"

#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "formats/base/files/atomic_file.h"
#include "tests/support/box_world.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"
#include "tests/system/program.h"

namespace sightline {
namespace {

constexpr double kVoxel_m = 0.25;
constexpr double kRange_m = 30.0;

octomap::point3d to_octomap(const Eigen::Vector3d& p_m) {
  return {static_cast<float>(p_m.x()), static_cast<float>(p_m.y()), static_cast<float>(p_m.z())};
}

std::vector<std::byte> exported(const SurfacePoints& surface, int threads = 1) {
  return value_of(octomap_bt(surface, {kVoxel_m, kRange_m, threads}));
}

octomap::OcTree read_back(const std::vector<std::byte>& bytes) {
  std::istringstream stream(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  octomap::OcTree tree(1.0);
  EXPECT_TRUE(tree.readBinary(stream));
  return tree;
}

enum class Space { kUnknown, kFree, kOccupied };

Space space_at(const octomap::OcTree& tree, const Eigen::Vector3d& p_m) {
  const octomap::OcTreeNode* node = tree.search(to_octomap(p_m));
  if (node == nullptr) return Space::kUnknown;
  return tree.isNodeOccupied(node) ? Space::kOccupied : Space::kFree;
}

SurfacePoints surface_of(const TestDrive& test) {
  SurfacePoints surface;
  surface.store = test.drive.store;
  for (std::uint32_t i = 0; i < test.drive.scans.size(); ++i) {
    const Pose T_map_lidar = test.truth.poses[i].T_map_vehicle * test.drive.sensor.T_vehicle_lidar;
    surface.scans.push_back({i, T_map_lidar, 0.5, 100.0});
  }
  return surface;
}

// All coordinates are multiples of 1/1024 m, so that floats hold them and their sums exactly, and
// off the faces of voxels.
SurfacePoints street(int scan_count, double azimuth_step_deg = 3.0) {
  const BoxWorld world = random_street(3);
  std::vector<Scan> scans;
  std::vector<Pose> poses;
  for (int i = 0; i < scan_count; ++i) {
    Pose T_map_lidar = Pose::Identity();
    T_map_lidar.translation() = Eigen::Vector3d(0.75 * i, 0.0, 2.0);
    Scan scan = scan_world(world, T_map_lidar, azimuth_step_deg);
    for (Eigen::Vector3d& p_m : scan.points_m) p_m = (1024.0 * p_m).array().round() / 1024.0;
    scans.push_back(scan);
    poses.push_back(Pose::Identity());
    poses.back().translation() =
        Eigen::Vector3d(0.75 * i, 0.0, 0.0) + Eigen::Vector3d(13.0, 27.0, 51.0) / 1024.0;
  }
  return surface_of(drive_of(std::move(scans), poses));
}

// One ray of 5.1 m along x from 2 m above the origin: 20 voxels of free space and one occupied.
TEST(Octomap, HoldsTheWayOfARayAsFreeAndItsEndAsOccupied) {
  Scan scan;
  scan.points_m = {{5.1, 0.1, 0.1}};
  const SurfacePoints surface = surface_of(drive_of({scan}, {Pose::Identity()}));
  const octomap::OcTree tree = read_back(exported(surface));
  EXPECT_EQ(tree.getResolution(), kVoxel_m);
  EXPECT_EQ(space_at(tree, {5.1, 0.1, 2.1}), Space::kOccupied);
  for (const double x_m : {0.1, 1.3, 4.9}) {
    EXPECT_EQ(space_at(tree, {x_m, 0.1, 2.1}), Space::kFree) << x_m;
  }
  EXPECT_EQ(space_at(tree, {5.3, 0.1, 2.1}), Space::kUnknown) << "behind it";
  EXPECT_EQ(space_at(tree, {3.0, 0.4, 2.1}), Space::kUnknown) << "beside the ray";
}

TEST(Octomap, LiesInTheWorldWhereItsKeysReachSoFar) {
  Scan scan;
  scan.points_m = {{5.1, 0.1, 0.1}};
  SurfacePoints surface = surface_of(drive_of({scan}, {Pose::Identity()}));
  surface.frame.origin_world_m = {-64.0, 128.0, 0.0};
  EXPECT_EQ(space_at(read_back(exported(surface)), {-58.9, 128.1, 2.1}), Space::kOccupied);
  surface.frame.origin_world_m = {456'512.0, 5'429'504.0, 0.0};
  EXPECT_EQ(space_at(read_back(exported(surface)), {5.1, 0.1, 2.1}), Space::kOccupied);
  const OctomapFrame near = octomap_frame({{400'128.0, 64.0, 0.0}}, kVoxel_m);
  EXPECT_TRUE(near.is_of_exports);
  EXPECT_EQ(near.shift_m, Eigen::Vector3d(128.0, 64.0, 0.0));
  EXPECT_FALSE(octomap_frame(surface.frame, kVoxel_m).is_of_exports);
}

TEST(Octomap, KnowsOfALongRayItsBeginningOnly) {
  Scan scan;
  scan.points_m = {{40.1, 0.1, 0.1}};
  const octomap::OcTree tree =
      read_back(exported(surface_of(drive_of({scan}, {Pose::Identity()}))));
  EXPECT_EQ(space_at(tree, {29.6, 0.1, 2.1}), Space::kFree);
  EXPECT_EQ(space_at(tree, {30.4, 0.1, 2.1}), Space::kUnknown);
  EXPECT_EQ(space_at(tree, {40.1, 0.1, 2.1}), Space::kUnknown);
}

// Two hits would be occupied.
TEST(Octomap, LeavesOutWhatMovedAndKeepsTheWayToIt) {
  Scan hit;
  hit.points_m = {{5.1, 0.1, 0.1}};
  SurfacePoints surface = surface_of(drive_of({hit, hit}, {Pose::Identity(), Pose::Identity()}));
  surface.voxel_m = 0.2;
  surface.moved_voxels = {cell_key({5.1, 0.1, 2.1}, 0.2)};
  const octomap::OcTree tree = read_back(exported(surface));
  EXPECT_EQ(space_at(tree, {5.1, 0.1, 2.1}), Space::kUnknown);
  EXPECT_EQ(space_at(tree, {2.5, 0.1, 2.1}), Space::kFree);
}

// OctoMap carves ground and edges where rays of other scans pass at a small angle: 13 returns of
// 100 here lie in a voxel that is free in the end.
TEST(Octomap, OccupiesOnlyWhereReturnsLieAndFreesOnlyWhereRaysPass) {
  const SurfacePoints surface = street(6);
  const octomap::OcTree tree = read_back(exported(surface));
  octomap::KeySet hit;
  octomap::KeySet passed;
  const SurfacePointReader reader(surface);
  std::size_t returns = 0;
  std::size_t occupied_returns = 0;
  for (std::size_t part = 0; part < reader.part_count(); ++part) {
    const octomap::point3d origin = to_octomap(surface.scans[part].T_map_lidar.translation());
    const std::vector<Eigen::Vector3d> ends_m = value_of(reader.standing(part));
    for (const Eigen::Vector3d& end_m : ends_m) {
      octomap::KeyRay ray;
      octomap::point3d end = to_octomap(end_m);
      const bool is_within = (end - origin).norm() <= kRange_m;
      if (is_within) hit.insert(tree.coordToKey(end));
      if (!is_within) end = origin + (end - origin).normalized() * static_cast<float>(kRange_m);
      ASSERT_TRUE(tree.computeRayKeys(origin, end, ray));
      passed.insert(ray.begin(), ray.end());
      returns += is_within ? 1 : 0;
      occupied_returns += is_within && space_at(tree, end_m) == Space::kOccupied ? 1 : 0;
    }
  }
  std::size_t leaves = 0;
  for (octomap::OcTree::leaf_iterator leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
    if (leaf.getDepth() < tree.getTreeDepth()) continue;  // eight alike, or more, in one
    const octomap::KeySet& allowed = tree.isNodeOccupied(*leaf) ? hit : passed;
    ASSERT_EQ(allowed.count(leaf.getKey()), 1u) << leaf.getX() << " " << leaf.getY();
    ++leaves;
  }
  EXPECT_GT(leaves, 10'000u);
  for (const octomap::KeySet& keys : {hit, passed}) {
    for (const octomap::OcTreeKey& key : keys) ASSERT_NE(tree.search(key), nullptr);
  }
  EXPECT_GT(static_cast<double>(occupied_returns), 0.8 * static_cast<double>(returns));
}

std::string text_of(const octomap::OcTree& tree) {
  std::ostringstream text;
  tree.writeBinaryConst(text);
  return text.str();
}

// By OctoMap itself, scan by scan.
std::string inserted(const SurfacePoints& surface) {
  octomap::OcTree tree(kVoxel_m);
  const SurfacePointReader reader(surface);
  for (std::size_t part = 0; part < reader.part_count(); ++part) {
    octomap::Pointcloud ends;
    for (const Eigen::Vector3d& end_m : value_of(reader.standing(part))) {
      ends.push_back(to_octomap(end_m));
    }
    tree.insertPointCloud(ends, to_octomap(surface.scans[part].T_map_lidar.translation()),
                          kRange_m);
  }
  tree.toMaxLikelihood();
  tree.prune();
  return text_of(tree);
}

// A drive of 150 m with a range of 30 m, which leaves tiles behind, and comes back to the first.
TEST(Octomap, IsTheTreeOfInsertPointCloudScanByScan) {
  SurfacePoints surface = street(11, 12.0);
  for (std::size_t i = 0; i < surface.scans.size(); ++i) {
    const double way_m = i < 10 ? 16.0 * static_cast<double>(i) : 0.0;
    surface.scans[i].T_map_lidar.translation().x() = way_m + 0.046875;
  }
  const octomap::OcTree ours = read_back(exported(surface));
  EXPECT_GT(ours.size(), 10'000u);
  EXPECT_TRUE(text_of(ours) == inserted(surface));
}

// The log-odds reach their lower limit, their upper one and the lower one again.
TEST(Octomap, CountsMissesAnewAfterHits) {
  Scan hit;
  hit.points_m = {{5.1, 0.1, 0.1}};
  Scan miss;
  miss.points_m = {{8.1, 0.1, 0.1}};
  for (const int last_misses : {0, 5, 8, 9, 12}) {
    std::vector<Scan> scans(7, miss);
    scans.insert(scans.end(), 8, hit);
    scans.insert(scans.end(), static_cast<std::size_t>(last_misses), miss);
    const SurfacePoints surface =
        surface_of(drive_of(scans, std::vector<Pose>(scans.size(), Pose::Identity())));
    const octomap::OcTree ours = read_back(exported(surface));
    EXPECT_TRUE(text_of(ours) == inserted(surface)) << last_misses;
    EXPECT_EQ(space_at(ours, {5.1, 0.1, 2.1}), last_misses < 9 ? Space::kOccupied : Space::kFree)
        << last_misses;
  }
}

// From the middle of a voxel: faces of several axes are equally far.
TEST(Octomap, FollowsRaysThroughEdgesAndCornersAsInsertPointCloud) {
  Scan scan;
  for (const double x : {-4.0, 0.0, 4.0}) {
    for (const double y : {-4.0, 0.0, 4.0}) {
      for (const double z : {-4.0, 0.0, 4.0}) {
        if (x != 0.0 || y != 0.0 || z != 0.0) scan.points_m.emplace_back(x, y, z);
      }
    }
  }
  Pose at_centre = Pose::Identity();
  at_centre.translation() = Eigen::Vector3d(0.125, 0.125, 0.125);
  const SurfacePoints surface = surface_of(drive_of({scan}, {at_centre}));
  EXPECT_TRUE(text_of(read_back(exported(surface))) == inserted(surface));
}

TEST(Octomap, IsTheTreeThatOctomapsOwnToolsMakeOfTheScans) {
  if (run_command("command -v log2graph graph2tree bt2vrml").status != 0) {
    GTEST_SKIP() << "there is no graph2tree (Debian package octomap-tools)";
  }
  const SurfacePoints surface = street(3);
  const std::filesystem::path folder = fresh_folder();
  std::ofstream log(folder / "street.log");
  log.precision(15);
  const SurfacePointReader reader(surface);
  for (std::size_t part = 0; part < reader.part_count(); ++part) {
    const Eigen::Vector3d origin_m = surface.scans[part].T_map_lidar.translation();
    log << "NODE " << origin_m.transpose() << " 0 0 0\n";
    const std::vector<Eigen::Vector3d> points_m = value_of(reader.standing(part));
    for (const Eigen::Vector3d& p_m : points_m) {
      const Eigen::Vector3d ray_m = p_m - origin_m;
      log << ray_m.x() << " " << ray_m.y() << " " << ray_m.z() << "\n";
    }
  }
  log.close();
  const std::string in_folder = "cd '" + folder.string() + "' && ";
  const ProgramResult made = run_command(
      in_folder + "log2graph street.log street.graph && graph2tree -i street.graph -o tools.bt " +
      "-res 0.25 -m 30");
  ASSERT_EQ(made.status, 0) << made.err;
  ASSERT_TRUE(write_file_atomically(folder / "ours.bt", exported(surface), IfExists::kReplace));
  octomap::OcTree ours(1.0);
  octomap::OcTree theirs(1.0);
  ASSERT_TRUE(ours.readBinary((folder / "ours.bt").string()));
  ASSERT_TRUE(theirs.readBinary((folder / "tools.bt").string()));
  EXPECT_GT(ours.size(), 10'000u);
  EXPECT_TRUE(ours == theirs);

  ASSERT_EQ(run_command(in_folder + "bt2vrml ours.bt").status, 0);
  std::size_t occupied = 0;
  for (octomap::OcTree::leaf_iterator leaf = ours.begin_leafs(); leaf != ours.end_leafs(); ++leaf) {
    occupied += ours.isNodeOccupied(*leaf) ? 1 : 0;
  }
  const ProgramResult boxes = run_command(in_folder + "grep -c 'Box {' ours.bt.wrl");
  EXPECT_EQ(boxes.out, std::to_string(occupied) + "\n");
}

TEST(Octomap, GivesTheSameBytesForAnyNumberOfThreads) {
  const SurfacePoints surface = street(11, 12.0);
  const std::vector<std::byte> one = exported(surface, 1);
  EXPECT_EQ(exported(surface, 2), one);
  EXPECT_EQ(exported(surface, 7), one);
}

ErrorCode error_of(const SurfacePoints& surface, const OctomapOptions& options) {
  return code_of(octomap_bt(surface, options));
}

TEST(Octomap, RefusesWhatItCannotHold) {
  const SurfacePoints surface = street(1);
  EXPECT_EQ(error_of(surface, {0.0, 30.0, 1}), ErrorCode::kBadValue);
  EXPECT_EQ(error_of(surface, {0.25, 0.0, 1}), ErrorCode::kBadValue);
  EXPECT_EQ(error_of({}, {0.25, 30.0, 1}), ErrorCode::kEmptyMap);
  SurfacePoints far = surface;
  far.scans[0].T_map_lidar.translation().x() = 8190.0;  // 0.25 m times 32768 is 8192 m
  EXPECT_EQ(error_of(far, {0.25, 30.0, 1}), ErrorCode::kBadValue);
  EXPECT_EQ(error_of(far, {0.5, 30.0, 1}), ErrorCode{});
}

}  // namespace
}  // namespace sightline
