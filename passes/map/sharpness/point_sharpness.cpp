#include "passes/map/sharpness/point_sharpness.h"

#include <Eigen/LU>
#include <algorithm>
#include <iterator>
#include <numbers>
#include <optional>

#include "formats/base/parallel.h"
#include "formats/base/portable_math.h"
#include "formats/grid/cell_index.h"
#include "formats/surroundings/cell_moments.h"
#include "passes/map/build_ndt.h"

namespace sightline {
namespace {

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

void sum_entropy(const std::vector<Eigen::Vector3d>& points_m, const IsOwn& is_own, double radius_m,
                 int threads, SharpnessSums& sums) {
  const Neighbourhood around(points_m, radius_m);
  std::vector<std::size_t> queries;
  std::size_t own_count = 0;
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    if (!is_own(around.points_m()[i])) continue;
    if (own_count % kQueryStep == 0) queries.push_back(i);
    ++own_count;
  }
  queries.resize(own_count / kQueryStep);
  const std::vector<std::optional<double>> found = parallel_map<std::optional<double>>(
      queries.size(), threads, [&](std::size_t i) -> std::optional<double> {
        return around.entropy_nat(around.points_m()[queries[i]]);
      });
  std::vector<double> entropies_nat;
  for (const std::optional<double>& entropy_nat : found) {
    if (entropy_nat) entropies_nat.push_back(*entropy_nat);
  }
  sums.entropy_points = entropies_nat.size();
  sums.entropy_nat = ordered_sum(entropies_nat);
}

void sum_planes(const std::vector<Eigen::Vector3d>& own_m, double cell_m, int threads,
                SharpnessSums& sums) {
  BuildNdtOptions options;
  options.cell_m = cell_m;
  options.tile_m = 32.0 * cell_m;
  std::vector<double> variances_m2;
  for (const Nd& nd : ndt_from_points(own_m, MapFrame{}, options, threads).nds) {
    variances_m2.push_back(nd.point_count * nd.eigenvalues_m2[2]);
    sums.plane_points += nd.point_count;
  }
  sums.plane_variance_m2 = ordered_sum(variances_m2);
}

}  // namespace

SharpnessSums sharpness_sums(const std::vector<Eigen::Vector3d>& points_m, const IsOwn& is_own,
                             const MeasureSharpnessOptions& options, int threads) {
  SharpnessSums sums;
  sum_entropy(points_m, is_own, options.radius_m, threads, sums);
  std::vector<Eigen::Vector3d> own_m;
  std::ranges::copy_if(points_m, std::back_inserter(own_m), is_own);
  sum_planes(own_m, options.cell_m, threads, sums);
  return sums;
}

SharpnessFigures figures_of(const std::vector<SharpnessSums>& all) {
  SharpnessFigures figures;
  std::vector<double> entropies_nat;
  std::vector<double> variances_m2;
  for (const SharpnessSums& sums : all) {
    entropies_nat.push_back(sums.entropy_nat);
    variances_m2.push_back(sums.plane_variance_m2);
    figures.entropy_points += sums.entropy_points;
    figures.plane_points += sums.plane_points;
  }
  if (figures.entropy_points > 0) {
    figures.mean_entropy_nat =
        ordered_sum(entropies_nat) / static_cast<double>(figures.entropy_points);
  }
  if (figures.plane_points > 0) {
    figures.mean_plane_variance_m2 =
        ordered_sum(variances_m2) / static_cast<double>(figures.plane_points);
  }
  return figures;
}

SharpnessFigures sharpness_of(const std::vector<Eigen::Vector3d>& points_m,
                              const MeasureSharpnessOptions& options, int threads) {
  const IsOwn all = [](const Eigen::Vector3d&) { return true; };
  return figures_of({sharpness_sums(points_m, all, options, threads)});
}

}  // namespace sightline
