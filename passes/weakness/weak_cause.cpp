#include "passes/weakness/weak_cause.h"

#include <array>
#include <cmath>
#include <numbers>
#include <set>

#include "formats/base/portable_math.h"
#include "formats/symmetric_eigen.h"

namespace sightline {
namespace {

// Fewer upright surfaces of 2 m than this are two fronts of 10 m, one storey high.
constexpr std::size_t kFew = 20;
// One in twenty surfaces, at right angles to all others, is this one-sided.
constexpr double kOneSided = 0.95;
// A rival this good is within what traffic and other parked cars take from a score.
constexpr double kRival = 0.85;
constexpr double kFarShare = 0.5;  // of the range
constexpr double kHolds = 0.866;   // cosine of 30 degrees
constexpr double kUpright = 0.5;   // sine of 30 degrees: height of the normal

// Numbers of the NDs in which the scan has samples.
std::set<std::uint32_t> nds_in_sight(const SiteView& view, const NearNds& nds) {
  std::set<std::uint32_t> numbers;
  for (const auto& [key, voxel] : view.voxels) {
    const std::uint32_t number = nds.index.find(cell_of(voxel, view.p_map_m, nds.cell_m));
    if (number != CellIndex::kNone) numbers.insert(number);
  }
  return numbers;
}

}  // namespace

std::string_view name_of(WeakCause cause) {
  constexpr std::array<std::string_view, 5> kNames = {"empty", "one-sided", "repeated", "distant",
                                                      "unclear"};
  return kNames[static_cast<std::size_t>(cause)];
}

UprightSights upright_sights(const SiteView& view, const NearNds& nds, double loose_heading_deg) {
  const SinCos loose = portable_sin_cos(loose_heading_deg * std::numbers::pi / 180.0);
  const Eigen::Vector2d way(loose.cos, loose.sin);
  UprightSights sights;
  Eigen::Matrix2d normals = Eigen::Matrix2d::Zero();
  for (const std::uint32_t number : nds_in_sight(view, nds)) {
    const Nd& nd = nds.nds[number];
    const Eigen::Vector3d normal = nd.eigenvectors.col(2);
    if (dimension_class(nd) != 2 || std::abs(normal.z()) > kUpright) continue;
    ++sights.count;
    const Eigen::Vector2d level = normal.head<2>().normalized();
    normals += level * level.transpose();
    if (std::abs(level.dot(way)) < kHolds) continue;
    ++sights.holding_count;
    const double away_m = (nd.mean_m - view.p_map_m).norm();
    sights.nearest_holding_m = std::min(away_m, sights.nearest_holding_m.value_or(away_m));
  }
  if (sights.count == 0) return sights;
  const SymmetricEigen<2> eigen = symmetric_eigen<2>(normals);
  sights.one_sidedness = 1.0 - eigen.values[0] / eigen.values[1];
  return sights;
}

WeakCause cause_of(const UprightSights& sights, std::optional<double> rival_score, double range_m) {
  if (sights.count < kFew) return WeakCause::kEmpty;
  if (sights.one_sidedness > kOneSided) return WeakCause::kOneSided;
  if (rival_score && *rival_score > kRival) return WeakCause::kRepeated;
  if (!sights.nearest_holding_m || *sights.nearest_holding_m > kFarShare * range_m) {
    return WeakCause::kDistant;
  }
  return WeakCause::kUnclear;
}

}  // namespace sightline
