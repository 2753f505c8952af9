#include "passes/matching/scan_cutter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "formats/base/check.h"
#include "formats/base/random.h"
#include "passes/matching/scan_preparation.h"

namespace sightline {
namespace {

VoxelBox box_within(double range_m, double leaf_m) {
  const Eigen::Vector3d corner_m = Eigen::Vector3d::Constant(range_m);
  return {cell_key(-corner_m, leaf_m), cell_key(corner_m, leaf_m)};
}

// Calls use(points) for those within the range, one return in `stride` looked at; some at a time,
// so that they stay in the nearest cache.
template <class Use>
void for_returns(std::span<const Eigen::Vector3d> points_m, double range_m, double stride,
                 const Use& use) {
  constexpr std::size_t kChunk = 512;
  std::array<Eigen::Vector3d, kChunk> within_m;
  const double range2_m2 = range_m * range_m;
  const auto index_of = [&](std::size_t n) {
    return static_cast<std::size_t>(static_cast<double>(n) * stride);
  };
  auto return_count =
      static_cast<std::size_t>(std::ceil(static_cast<double>(points_m.size()) / stride));
  if (return_count > 0 && index_of(return_count - 1) >= points_m.size()) --return_count;
  for (std::size_t first = 0; first < return_count; first += kChunk) {
    const std::size_t end = std::min(first + kChunk, return_count);
    // Without a branch: which returns are near is as good as random.
    std::size_t count = 0;
    for (std::size_t n = first; n < end; ++n) {
      const Eigen::Vector3d& point_m = points_m[index_of(n)];
      within_m[count] = point_m;
      count += point_m.squaredNorm() <= range2_m2 ? 1 : 0;
    }
    use(std::span<const Eigen::Vector3d>(within_m).first(count));
  }
}

// No corner of the box is farther from the vehicle, so nothing is cut but by the box.
constexpr double kBeyondBox_m = 100.0;

bool is_in_box(const Eigen::Vector3d& p_vehicle_m, double box_m) {
  return std::abs(p_vehicle_m.x()) <= box_m && std::abs(p_vehicle_m.y()) <= box_m &&
         p_vehicle_m.z() >= -AutowareSampler::kBoxBelow_m &&
         p_vehicle_m.z() <= AutowareSampler::kBoxAbove_m;
}

// `count` of the points, each as likely as any other: the first steps of a shuffle.
void keep_random(std::size_t count, Random random, std::vector<Eigen::Vector3d>& points_m) {
  if (points_m.size() <= count) return;
  for (std::size_t i = 0; i < count; ++i) {
    std::swap(points_m[i], points_m[i + random.below(points_m.size() - i)]);
  }
  points_m.resize(count);
}

}  // namespace

double even_stride(double longest) {
  // The golden ratio's fraction, of all numbers the farthest from every fraction.
  constexpr double kGolden = std::numbers::phi - 1.0;
  return longest < 1.0 + kGolden ? 1.0 : std::floor(longest - kGolden) + kGolden;
}

double return_stride(const ScanCut& cut, double azimuth_step_deg) {
  if (cut.takes_every_return) return 1.0;
  constexpr double kReturnsAcrossVoxel = 4.0;
  const double spacing_m = cut.range_m * azimuth_step_deg * std::numbers::pi / 180.0;
  return even_stride(cut.leaf_m / (kReturnsAcrossVoxel * spacing_m));
}

std::vector<Eigen::Vector3d> ScanCutter::cut(std::span<const Eigen::Vector3d> points_m,
                                             const ScanCut& cut, double stride) {
  SIGHTLINE_CHECK(cut.range_m > 0.0 && cut.leaf_m > 0.0 && stride >= 1.0);
  const VoxelBox box = box_within(cut.range_m, cut.leaf_m);
  if (cell_count(box) <= kMostTableCells) {
    voxels_.begin(box);
    for_returns(points_m, cut.range_m, stride, [&](std::span<const Eigen::Vector3d> within_m) {
      voxels_.add(within_m, cut.leaf_m);
    });
    return voxels_.take_centroids_m();
  }
  std::vector<Eigen::Vector3d> all_within_m;
  for_returns(points_m, cut.range_m, stride, [&](std::span<const Eigen::Vector3d> within_m) {
    all_within_m.insert(all_within_m.end(), within_m.begin(), within_m.end());
  });
  return voxel_subsample(all_within_m, cut.leaf_m);
}

std::vector<Eigen::Vector3d> AutowareSampler::sample(const Scan& scan, const SensorProfile& sensor,
                                                     const AutowareFilters& filters,
                                                     std::uint64_t seed) {
  const double range2_m2 = filters.range_m * filters.range_m;
  in_box_m_.resize(std::max(in_box_m_.size(), scan.points_m.size()));
  std::size_t count = 0;
  for (const Eigen::Vector3d& p_sensor_m : scan.points_m) {
    const Eigen::Vector3d p_vehicle_m = sensor.T_vehicle_lidar * p_sensor_m;
    in_box_m_[count] = p_vehicle_m;  // without a branch: which are inside is as good as random
    const bool is_kept =
        p_sensor_m.squaredNorm() <= range2_m2 && is_in_box(p_vehicle_m, filters.box_m);
    count += is_kept ? 1 : 0;
  }
  std::vector<Eigen::Vector3d> points_m =
      cutter_.cut(std::span(in_box_m_).first(count), {kBeyondBox_m, filters.voxel_m}, 1.0);
  keep_random(filters.most_points, Random(seed), points_m);
  return points_m;
}

}  // namespace sightline
