#include <gtest/gtest.h>
#include <octomap/OcTree.h>
#include <algorithm>
#include <array>
#include <cmath>

#include "passes/map/tile_carver.h"
#include "tests/support/box_world.h"
#include "tests/support/test_context.h"

// OctoMap's ray insertion beside what the pass sees of the same scans. Both count a voxel once a
// scan and sum the same log odds of hits and misses. Of a hit both mean the same: a return within
// the voxel. Of a miss they do not: OctoMap means that a ray crosses the voxel anywhere, the pass
// that it passes within half a voxel of the voxel's own points and goes on for half a metre (see
// tile_carver.cpp).

namespace sightline {
namespace {

constexpr double kVoxel_m = 0.2;
// A tile that holds everything around its middle.
constexpr double kTile_m = 400.0;
constexpr TileKey kTile{0, 0};
constexpr double kMiddle_m = 200.0;

CarveOptions one_big_tile() {
  CarveOptions options{.voxel_m = kVoxel_m};
  options.carve_range_m = 100.0;
  options.tile_m = kTile_m;
  return options;
}

octomap::point3d to_octomap(const Eigen::Vector3d& p_m) {
  return {static_cast<float>(p_m.x()), static_cast<float>(p_m.y()), static_cast<float>(p_m.z())};
}

// Voxels of both have the same edges: OctoMap counts from 32768 below 0.
octomap::OcTreeKey octomap_key(const CellKey& key) {
  return {static_cast<octomap::key_type>(key.x + 32768),
          static_cast<octomap::key_type>(key.y + 32768),
          static_cast<octomap::key_type>(key.z + 32768)};
}

Eigen::Vector3d centre_m(const CellKey& key) {
  return kVoxel_m * Eigen::Vector3d(key.x + 0.5, key.y + 0.5, key.z + 0.5);
}

struct SeenWorld {
  std::vector<PlacedScan> placed;
  std::vector<Scan> scans;

  void add(const Pose& T_map_lidar, const std::vector<Eigen::Vector3d>& ends_m) {
    Scan scan;
    for (const Eigen::Vector3d& end_m : ends_m) {
      scan.points_m.push_back(T_map_lidar.inverse() * end_m);
    }
    placed.push_back({static_cast<std::uint32_t>(scans.size()), T_map_lidar, 0.0, 200.0});
    scans.push_back(scan);
  }

  [[nodiscard]] octomap::point3d origin(std::size_t k) const {
    return to_octomap(placed[k].T_map_lidar.translation());
  }

  [[nodiscard]] octomap::Pointcloud ends(std::size_t k) const {
    octomap::Pointcloud cloud;
    for (const Eigen::Vector3d& p_m : scans[k].points_m) {
      cloud.push_back(to_octomap(placed[k].T_map_lidar * p_m));
    }
    return cloud;
  }

  [[nodiscard]] SeenVoxels seen_by_the_pass() const {
    return value_of(look_at_tile(one_big_tile(), *memory_scan_store(scans), placed, kTile));
  }

  // Its sensor model as it is, and no clamping: the pass clamps nothing.
  [[nodiscard]] octomap::OcTree seen_by_octomap() const {
    octomap::OcTree tree(kVoxel_m);
    tree.setClampingThresMin(1e-9);
    tree.setClampingThresMax(1.0 - 1e-6);
    for (std::size_t k = 0; k < scans.size(); ++k) tree.insertPointCloud(ends(k), origin(k));
    return tree;
  }
};

struct Ray {
  Eigen::Vector3d origin_m;
  Eigen::Vector3d end_m;
};

double distance_m(const Ray& ray, const Eigen::Vector3d& p_m) {
  const Eigen::Vector3d way_m = ray.end_m - ray.origin_m;
  const double share = std::clamp(way_m.dot(p_m - ray.origin_m) / way_m.squaredNorm(), 0.0, 1.0);
  return (ray.origin_m + share * way_m - p_m).norm();
}

// A world in which both mean the same by a miss: things of one voxel each in open space, and rays
// that go through the middle of one thing's voxel or well past it.
class OpenWorld {
 public:
  explicit OpenWorld(std::uint64_t seed) : random_(seed) {
    while (things_.size() < kThings) {
      const CellKey key{cell(30.0), cell(30.0), 4 + static_cast<std::int32_t>(random_.below(20))};
      const Eigen::Vector3d at_m = centre_m(key);
      const bool is_free = std::ranges::all_of(
          things_, [&](const CellKey& other) { return (centre_m(other) - at_m).norm() > 2.0; });
      if (is_free && (at_m.head<2>().array() - kMiddle_m).matrix().norm() > 12.0)
        things_.push_back(key);
    }
  }

  // A thing is there or not, by chance; what cannot be seen apart is not looked at.
  void scan() {
    const Eigen::Vector3d origin_m(kMiddle_m + random_.uniform(-6.0, 6.0),
                                   kMiddle_m + random_.uniform(-6.0, 6.0), 2.03);
    std::vector<Eigen::Vector3d> ends_m;
    for (std::size_t i = 0; i < things_.size(); ++i) {
      const Eigen::Vector3d at_m = centre_m(things_[i]);
      // The ground below it, so that the thing itself is none.
      if (try_ray({origin_m, {at_m.x(), at_m.y(), 0.1}}, things_[i], ends_m)) has_ground_[i] = true;
      if (!has_ground_[i]) continue;
      const double behind_m = random_.below(4) == 0 ? 0.0 : random_.uniform(9.0, 11.0);
      const Eigen::Vector3d way_m = at_m - origin_m;
      try_ray({origin_m, at_m + behind_m * way_m.normalized()}, things_[i], ends_m);
    }
    Pose T_map_lidar = pose_at(0.0, 0.0, random_.uniform(-3.0, 3.0));
    T_map_lidar.translation() = origin_m;
    world_.add(T_map_lidar, ends_m);
  }

  [[nodiscard]] const SeenWorld& world() const { return world_; }

 private:
  static constexpr std::size_t kThings = 20;

  std::int32_t cell(double most_m) {
    return static_cast<std::int32_t>(
        std::floor((kMiddle_m + random_.uniform(-most_m, most_m)) / kVoxel_m));
  }

  bool try_ray(const Ray& ray, const CellKey& target, std::vector<Eigen::Vector3d>& ends_m) {
    constexpr double kApart_m = 0.4;  // more than a voxel's diagonal
    const CellKey end = cell_key(ray.end_m, kVoxel_m);
    const bool is_inside =  // floats find the same voxel
        ((ray.end_m - centre_m(end)).array().abs() < 0.45 * kVoxel_m).all();
    const auto is_far = [&](const CellKey& key) {
      return key == target || key == end || distance_m(ray, centre_m(key)) > kApart_m;
    };
    const bool misses_all =
        std::ranges::all_of(things_, is_far) && std::ranges::all_of(others_, is_far);
    const bool is_missed = end == target || std::ranges::all_of(rays_, [&](const Ray& other) {
                             return distance_m(other, centre_m(end)) > kApart_m ||
                                    cell_key(other.end_m, kVoxel_m) == end;
                           });
    if (!is_inside || !misses_all || !is_missed) return false;
    rays_.push_back(ray);
    if (end != target) others_.push_back(end);
    ends_m.push_back(ray.end_m);
    return true;
  }

  Random random_;
  std::vector<CellKey> things_;
  std::array<bool, kThings> has_ground_{};  // a scan hit the ground below it
  std::vector<CellKey> others_;             // hit beyond and below them
  std::vector<Ray> rays_;
  SeenWorld world_;
};

TEST(RemoveMovingBesideOctomap, SeesTheSameWhereBothMeanTheSame) {
  int free_count = 0;
  int occupied_count = 0;
  for (std::uint64_t seed = 1; seed <= 25; ++seed) {
    OpenWorld open(seed);
    for (int k = 0; k < 8; ++k) open.scan();
    const SeenVoxels seen = open.world().seen_by_the_pass();
    const octomap::OcTree tree = open.world().seen_by_octomap();
    const std::vector<std::uint8_t> moved = judge(seen);
    ASSERT_GT(seen.size(), 20u);
    for (std::size_t v = 0; v < seen.size(); ++v) {
      const octomap::OcTreeNode* node = tree.search(octomap_key(seen.keys()[v]));
      ASSERT_NE(node, nullptr);
      ASSERT_NEAR(log_odds(seen.values()[v]), node->getLogOdds(), 1e-5) << "seed " << seed;
      // What hangs higher in the air does not go alone, free or not.
      if (seen.values()[v].above_ground_m > 2.0F) continue;
      ASSERT_EQ(moved[v] == 1, node->getLogOdds() < 0.0F) << "seed " << seed;
      (moved[v] == 1 ? free_count : occupied_count) += 1;
    }
  }
  EXPECT_GT(free_count, 30);
  EXPECT_GT(occupied_count, 500);
}

SeenWorld street_with_car() {
  const Eigen::Vector3d shift_m(kMiddle_m + 0.013, kMiddle_m + 0.027, 0.051);
  SeenWorld seen;
  for (int k = 0; k < 14; ++k) {
    BoxWorld world = random_street(1);
    world.boxes.push_back({{25.0 - 2 * k, 2.0, 0.25}, {29.0 - 2 * k, 3.8, 1.6}});
    Pose T_map_lidar = lidar_at(0.5 * k, 0.0, 0.0);
    const Scan scan = scan_world(world, T_map_lidar, 2.0);
    std::vector<Eigen::Vector3d> ends_m;
    for (const Eigen::Vector3d& p_m : scan.points_m) ends_m.push_back(T_map_lidar * p_m + shift_m);
    T_map_lidar.translation() += shift_m;
    seen.add(T_map_lidar, ends_m);
  }
  return seen;
}

struct Counts {
  std::uint32_t hits = 0;
  std::uint32_t misses = 0;
  std::uint32_t scans_beside = 0;  // with a ray through it or one of the 26 around it
};

std::vector<Counts> counts_of_octomap(const SeenWorld& world, const SeenVoxels& seen) {
  octomap::OcTree tree(kVoxel_m);
  std::vector<Counts> counts(seen.size());
  for (std::size_t k = 0; k < world.scans.size(); ++k) {
    octomap::KeySet free = octomap::KeySet();
    octomap::KeySet occupied = octomap::KeySet();
    tree.computeUpdate(world.ends(k), world.origin(k), free, occupied, -1.0);
    octomap::KeySet passed = octomap::KeySet();
    for (const octomap::point3d& end : world.ends(k)) {
      octomap::KeyRay ray;
      EXPECT_TRUE(tree.computeRayKeys(world.origin(k), end, ray));
      passed.insert(ray.begin(), ray.end());
    }
    for (std::size_t v = 0; v < seen.size(); ++v) {
      const octomap::OcTreeKey key = octomap_key(seen.keys()[v]);
      counts[v].hits += occupied.count(key) > 0 ? 1 : 0;
      counts[v].misses += free.count(key) > 0 ? 1 : 0;
      bool is_beside = false;
      for (int code = 0; code < 27 && !is_beside; ++code) {
        const CellKey& c = seen.keys()[v];
        is_beside = passed.count(octomap_key(
                        {c.x + code % 3 - 1, c.y + code / 3 % 3 - 1, c.z + code / 9 - 1})) > 0;
      }
      counts[v].scans_beside += is_beside ? 1 : 0;
    }
  }
  return counts;
}

// Of 21966 voxels both find 617 free and 14706 occupied. The pass alone finds 1 free: a ray passed
// through the next voxel, within a tenth of a metre of this one's points. OctoMap alone finds 6642
// free: edges, and ground and walls that rays pass at a small angle. The pass keeps them: they
// stand.
TEST(RemoveMovingBesideOctomap, FindsHardlyAVoxelFreeThatOctomapDoesNot) {
  const SeenWorld world = street_with_car();
  const SeenVoxels seen = world.seen_by_the_pass();
  const std::vector<Counts> counts = counts_of_octomap(world, seen);
  int both_free = 0;
  int free_to_us_alone = 0;
  int free_to_octomap_alone = 0;
  for (std::size_t v = 0; v < seen.size(); ++v) {
    const SeenVoxel& voxel = seen.values()[v];
    ASSERT_EQ(voxel.hits, counts[v].hits);
    // The point of a ray that is nearest to the voxel's points lies at most half a voxel away.
    ASSERT_LE(voxel.misses, counts[v].scans_beside);
    SeenVoxel to_octomap;
    to_octomap.hits = counts[v].hits;
    to_octomap.misses = counts[v].misses;
    const bool is_free = log_odds(voxel) < 0.0;
    const bool is_free_to_octomap = log_odds(to_octomap) < 0.0;
    both_free += is_free && is_free_to_octomap ? 1 : 0;
    free_to_us_alone += is_free && !is_free_to_octomap ? 1 : 0;
    free_to_octomap_alone += !is_free && is_free_to_octomap ? 1 : 0;
  }
  EXPECT_GT(both_free, 500);
  EXPECT_LT(free_to_us_alone, both_free / 100);
  EXPECT_LT(free_to_octomap_alone, static_cast<int>(seen.size()) / 3);
}

}  // namespace
}  // namespace sightline
