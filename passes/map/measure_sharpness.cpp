#include "passes/map/measure_sharpness.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "formats/base/parallel.h"
#include "formats/base/portable_math.h"
#include "formats/drive/trajectory_of_drive.h"
#include "formats/grid/cell_index.h"
#include "formats/grid/cell_moments.h"
#include "passes/map/build_ndt.h"
#include "passes/matching/scan_preparation.h"

namespace sightline {
namespace {

// Points of a scan are thinned to one in a voxel, or near rings would outvote all else.
constexpr double kLeaf_m = 0.15;
// One point in so many is asked what lies around it.
constexpr std::size_t kQueryStep = 16;
// Fewer points around make no distribution.
constexpr double kLeastPoints = 10.0;
// What no sensor resolves: keeps the entropy of perfect planes finite.
constexpr double kFloor_m2 = 1e-6;

// Points by cells as wide as the radius: neighbours lie in the 27 cells around.
class Neighbourhood {
 public:
  Neighbourhood(const std::vector<Eigen::Vector3d>& points_m, double radius_m)
      : radius_m_(radius_m) {
    std::vector<std::pair<CellKey, std::uint32_t>> order;
    order.reserve(points_m.size());
    for (std::uint32_t i = 0; i < points_m.size(); ++i) {
      order.emplace_back(cell_key(points_m[i], radius_m), i);
    }
    std::ranges::sort(order);
    points_m_.reserve(points_m.size());
    for (const auto& [key, i] : order) {
      if (cells_.add(key) == begin_.size()) begin_.push_back(points_m_.size());
      points_m_.push_back(points_m[i]);
    }
    begin_.push_back(points_m_.size());
  }
  [[nodiscard]] const std::vector<Eigen::Vector3d>& points_m() const { return points_m_; }

  // h = ln(det(2 pi e Sigma)) / 2 of the points within the radius; none where they are too few.
  [[nodiscard]] std::optional<double> entropy_nat(const Eigen::Vector3d& at_m) const {
    const CellKey middle = cell_key(at_m, radius_m_);
    CellMoments around;
    for (int i = 0; i < 27; ++i) {
      const CellKey key{middle.x + i / 9 - 1, middle.y + i / 3 % 3 - 1, middle.z + i % 3 - 1};
      const std::uint32_t cell = cells_.find(key);
      if (cell == CellIndex::kNone) continue;
      for (std::size_t k = begin_[cell]; k < begin_[cell + 1]; ++k) {
        const Eigen::Vector3d off_m = points_m_[k] - at_m;
        if (off_m.squaredNorm() <= radius_m_ * radius_m_) around.add(off_m);
      }
    }
    if (around.count < kLeastPoints) return std::nullopt;
    const Eigen::Matrix3d covariance_m2 =
        around.covariance_m2() + kFloor_m2 * Eigen::Matrix3d::Identity();
    const double scale = 2.0 * std::numbers::pi * std::numbers::e;
    return 0.5 * portable_log(scale * scale * scale * covariance_m2.determinant());
  }

 private:
  double radius_m_;
  std::vector<Eigen::Vector3d> points_m_;  // by cell
  CellIndex cells_;
  std::vector<std::size_t> begin_;  // of each cell in points_m_, and the end of all
};

void measure_entropy(const std::vector<Eigen::Vector3d>& points_m, double radius_m, int threads,
                     SharpnessFigures& figures) {
  const Neighbourhood around(points_m, radius_m);
  const std::size_t queries = points_m.size() / kQueryStep;
  const std::vector<std::optional<double>> found = parallel_map<std::optional<double>>(
      queries, threads, [&](std::size_t i) -> std::optional<double> {
        return around.entropy_nat(around.points_m()[kQueryStep * i]);
      });
  std::vector<double> entropies_nat;
  for (const std::optional<double>& entropy_nat : found) {
    if (entropy_nat) entropies_nat.push_back(*entropy_nat);
  }
  figures.entropy_points = entropies_nat.size();
  if (entropies_nat.empty()) return;
  figures.mean_entropy_nat = ordered_sum(entropies_nat) / static_cast<double>(entropies_nat.size());
}

void measure_planes(const std::vector<Eigen::Vector3d>& points_m, double cell_m, int threads,
                    SharpnessFigures& figures) {
  BuildNdtOptions options;
  options.cell_m = options.tile_m = cell_m;
  options.tile_m = 32.0 * cell_m;
  std::vector<double> variances_m2;
  for (const Nd& nd : ndt_from_points(points_m, MapFrame{}, options, threads).nds) {
    variances_m2.push_back(nd.point_count * nd.eigenvalues_m2[2]);
    figures.plane_points += nd.point_count;
  }
  if (figures.plane_points == 0) return;
  figures.mean_plane_variance_m2 =
      ordered_sum(variances_m2) / static_cast<double>(figures.plane_points);
}

struct TakenScan {
  std::size_t index = 0;
  std::vector<Eigen::Vector3d> points_m;  // vehicle frame
};

// One scan in so much of the way, thinned.
Result<std::vector<TakenScan>> take_scans(PassContext& ctx, const MeasureSharpnessOptions& options,
                                          const Drive& drive, const Trajectory& trajectory) {
  std::vector<TakenScan> taken;
  for (std::size_t k = 0; k < drive.scans.size(); ++k) {
    const Eigen::Vector3d at_m = trajectory.poses[k].T_map_vehicle.translation();
    if (!taken.empty()) {
      const Pose& last = trajectory.poses[taken.back().index].T_map_vehicle;
      if ((at_m - last.translation()).norm() < options.scan_step_m) continue;
    }
    taken.push_back({k, {}});
  }
  std::vector<std::optional<Error>> errors(taken.size());
  parallel_for(taken.size(), ctx.threads, [&](std::size_t i) {
    const Result<Scan> scan = drive.store->read(taken[i].index);
    if (!scan) {
      errors[i] = scan.error();
      return;
    }
    const SensorProfile& sensor = drive.sensor_of(drive.scans[taken[i].index]);
    std::vector<Eigen::Vector3d> near_m;
    for (const Eigen::Vector3d& point_m : crop(scan->points_m, options.reach_m)) {
      if (point_m.norm() >= sensor.min_range_m) near_m.push_back(point_m);
    }
    for (const Eigen::Vector3d& point_m : voxel_subsample(near_m, kLeaf_m)) {
      taken[i].points_m.push_back(sensor.T_vehicle_lidar * point_m);
    }
  });
  for (const std::optional<Error>& error : errors) {
    if (error) return *error;
  }
  return taken;
}

template <class PoseOf>
std::vector<Eigen::Vector3d> lay(const std::vector<TakenScan>& scans, const PoseOf& pose_of) {
  std::vector<Eigen::Vector3d> points_m;
  for (const TakenScan& scan : scans) {
    const Pose T_map_vehicle = pose_of(scan.index);
    for (const Eigen::Vector3d& point_m : scan.points_m)
      points_m.push_back(T_map_vehicle * point_m);
  }
  return points_m;
}

}  // namespace

std::vector<OptionField> option_fields(MeasureSharpnessOptions& options) {
  return {number("radius_m", options.radius_m, "around a point, for entropy, m", 0.1, 5.0),
          number("cell_m", options.cell_m, "of the NDs whose thickness is judged, m", 0.25, 10.0),
          number("scan_step_m", options.scan_step_m,
                 "of the way between the scans that are laid on each other, m", 0.1, 100.0),
          number("reach_m", options.reach_m, "returns farther from the sensor take no part, m", 5.0,
                 300.0)};
}

SharpnessFigures sharpness_of(const std::vector<Eigen::Vector3d>& points_m,
                              const MeasureSharpnessOptions& options, int threads) {
  SharpnessFigures figures;
  measure_entropy(points_m, options.radius_m, threads, figures);
  measure_planes(points_m, options.cell_m, threads, figures);
  return figures;
}

Result<Sharpness> measure_sharpness(PassContext& ctx, const MeasureSharpnessOptions& options,
                                    const Drive& drive, const Trajectory& trajectory) {
  SIGHTLINE_TRY(check_trajectory_of_drive(drive, trajectory));
  SIGHTLINE_ASSIGN(const std::vector<TakenScan> scans, take_scans(ctx, options, drive, trajectory));
  Sharpness sharpness;
  const std::vector<Eigen::Vector3d> laid_m =
      lay(scans, [&](std::size_t k) -> Pose { return trajectory.poses[k].T_map_vehicle; });
  sharpness.of_map = sharpness_of(laid_m, options, ctx.threads);
  const bool is_given = std::ranges::all_of(scans, [&](const TakenScan& scan) {
    return drive.scans[scan.index].T_world_vehicle.has_value();
  });
  if (trajectory.source == PoseSource::kGiven) {
    sharpness.of_given = sharpness.of_map;
  } else if (is_given && !scans.empty()) {
    const std::vector<Eigen::Vector3d> given_m = lay(scans, [&](std::size_t k) -> Pose {
      return rebase(*drive.scans[k].T_world_vehicle, MapFrame{}, drive.frame);
    });
    sharpness.of_given = sharpness_of(given_m, options, ctx.threads);
  }
  return sharpness;
}

}  // namespace sightline
