#pragma once

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "formats/base/random.h"
#include "formats/surroundings/surface_points.h"
#include "passes/pass/pass_context.h"

namespace sightline {

// A bumpy road along x with walls that have gaps, seen every few metres: over the edges of tiles of
// 256 m at y = 128 and x = -128 and 128. Some voxels have moved.
inline double range_in_street_m(const Eigen::Vector3d& from_m, const Eigen::Vector3d& direction) {
  double range_m = std::numeric_limits<double>::infinity();
  const auto meet = [&](double at_m) {
    if (at_m > 0.0) range_m = std::min(range_m, at_m);
  };
  meet((-1.8 - from_m.z()) / direction.z());
  for (const double wall_m : {-25.0, -8.0, 9.0, 30.0}) {
    const double at_m = (wall_m - from_m.y()) / direction.y();
    const double along_m = from_m.x() + at_m * direction.x();
    const double height_m = from_m.z() + at_m * direction.z();
    const bool is_gap = std::abs(wall_m) < 10.0 && std::fmod(std::abs(along_m), 19.0) < 7.0;
    if (!is_gap && height_m < 6.0) meet(at_m);
  }
  return range_m;
}

inline SurfacePoints long_street(std::uint64_t seed) {
  constexpr int kRays = 1500;
  Random random(seed);
  SurfacePoints points;
  std::vector<Scan> scans;
  for (double x_m = -200.0; x_m < 220.0; x_m += 11.0) {
    const Eigen::Vector3d from_m(x_m, random.uniform(-2.0, 2.0), 0.0);
    Scan scan;
    for (int i = 0; i < kRays; ++i) {
      const double azimuth_rad = random.uniform(-3.14, 3.14);
      const double elevation_rad = random.uniform(-0.25, 0.15);
      const Eigen::Vector3d direction(std::cos(elevation_rad) * std::cos(azimuth_rad),
                                      std::cos(elevation_rad) * std::sin(azimuth_rad),
                                      std::sin(elevation_rad));
      const double range_m = range_in_street_m(from_m, direction) + 0.02 * random.normal();
      if (range_m < 85.0) scan.points_m.emplace_back(range_m * direction);
    }
    Pose T_map_lidar = Pose::Identity();
    T_map_lidar.translation() = from_m + Eigen::Vector3d(0.0, 128.0, 0.0);
    points.scans.push_back({static_cast<std::uint32_t>(scans.size()), T_map_lidar, 1.0, 80.0, 0});
    scans.push_back(std::move(scan));
  }
  points.voxel_m = 0.5;
  for (const PlacedScan& placed : points.scans) {
    for (std::size_t i = 0; i < 20; ++i) {
      const Eigen::Vector3d at_m = placed.T_map_lidar * scans[placed.index].points_m[37 * i];
      points.moved_voxels.push_back(cell_key(at_m, points.voxel_m));
    }
  }
  std::ranges::sort(points.moved_voxels);
  points.moved_voxels.erase(std::unique(points.moved_voxels.begin(), points.moved_voxels.end()),
                            points.moved_voxels.end());
  points.store = memory_scan_store(std::move(scans));
  const SurfacePointReader reader(points);
  for (std::size_t part = 0; part < reader.part_count(); ++part) {
    points.standing_count += reader.standing(part)->size();
  }
  return points;
}

inline std::vector<Eigen::Vector3d> standing_m(const SurfacePoints& points) {
  const SurfacePointReader reader(points);
  std::vector<Eigen::Vector3d> all_m;
  for (std::size_t part = 0; part < reader.part_count(); ++part) {
    const std::vector<Eigen::Vector3d> part_m = *reader.standing(part);
    all_m.insert(all_m.end(), part_m.begin(), part_m.end());
  }
  return all_m;
}

struct NumberedParts {
  std::map<std::size_t, std::vector<std::byte>> parts;
  std::size_t count = 0;  // as the pass counted them

  PassContext context(int threads, WorkShare share = {}) {
    PassContext ctx;
    count = 0;
    ctx.threads = threads;
    ctx.share = share;
    ctx.saved_part = [this](const PartName& part) -> std::optional<std::vector<std::byte>> {
      const auto found = parts.find(part.number);
      return found == parts.end() ? std::nullopt : std::optional(found->second);
    };
    ctx.part_sink = [this](const PartName& part, std::span<const std::byte> bytes) {
      EXPECT_TRUE(parts.emplace(part.number, std::vector(bytes.begin(), bytes.end())).second)
          << "part " << part.number << " was made twice";
    };
    ctx.parts_sink = [this](std::span<const PartName> all) { count += all.size(); };
    return ctx;
  }
};

}  // namespace sightline
