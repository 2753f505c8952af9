#include "tests/support/lane/depth_truth.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "formats/base/check.h"
#include "formats/base/units.h"
#include "formats/geometry.h"

namespace sightline::lane {
namespace {

bool passes_leaves(const Lane& lane, const Eigen::Vector3d& p_m, const Eigen::Vector3d& direction,
                   double range_m) {
  return std::ranges::any_of(lane.leaf_balls, [&](const LeafBall& ball) {
    const Eigen::Vector3d to_ball_m = ball.centre_m - p_m;
    const double along_m = std::clamp(to_ball_m.dot(direction), 0.0, range_m);
    return (to_ball_m - along_m * direction).squaredNorm() <= ball.radius_m * ball.radius_m;
  });
}

double quantile(std::vector<double>& values, double share) {
  if (values.empty()) return 0.0;
  const auto at = static_cast<long>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

}  // namespace

Sites sites_along(const Lane& lane, double length_m, double spacing_m) {
  Sites sites;
  for (double way_m = 0.5; way_m < length_m; way_m += spacing_m) {
    Site site;
    site.p_map_m = sensor_pose(lane.ground, way_m).translation();
    sites.sites.push_back(site);
  }
  return sites;
}

std::vector<TrueRay> true_rays(const Lane& lane, const Caster& caster, const Sites& sites,
                               const DepthImages& images) {
  std::vector<TrueRay> rays;
  rays.reserve(images.distance_m.size());
  for (const Site& site : sites.sites) {
    for (std::size_t i = 0; i < images.cells_per_site(); ++i) {
      TrueRay ray;
      ray.elevation_deg = images.first_elevation_deg +
                          static_cast<double>(i / images.azimuth_count) * images.elevation_step_deg;
      const double azimuth_rad = (static_cast<double>(i % images.azimuth_count) + 0.5) * 2.0 *
                                 std::numbers::pi / images.azimuth_count;
      const Eigen::Vector3d direction = direction_of(azimuth_rad, ray.elevation_deg * kRadPerDeg);
      const Eigen::Vector3d from_m = site.p_map_m + images.near_m * direction;
      const Hit hit = caster.cast(from_m, direction);
      ray.range_m = hit.range_m + images.near_m;
      ray.kind = hit.kind;
      if (ray.range_m > images.longest_range_m) {
        ray.range_m = std::numeric_limits<double>::infinity();
        ray.kind = Kind::kGround;
      }
      const double way_m = std::min(ray.range_m, images.longest_range_m);
      ray.is_through_leaves =
          is_foliage(ray.kind) || passes_leaves(lane, site.p_map_m, direction, way_m);
      rays.push_back(ray);
    }
  }
  return rays;
}

Fidelity fidelity_of(const DepthImages& images, const std::vector<TrueRay>& truth,
                     const std::function<bool(const TrueRay&)>& counts) {
  constexpr double kFarOff_m = 0.5;
  SIGHTLINE_CHECK(truth.size() == images.distance_m.size());
  Fidelity fidelity;
  std::vector<double> error_m;
  double agreements = 0.0;
  double nearer = 0.0;
  double farther = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (!counts(truth[i])) continue;
    const double found_m = images.distance_m[i];
    const bool is_hit = std::isfinite(truth[i].range_m);
    ++fidelity.rays;
    agreements += is_hit == std::isfinite(found_m) ? 1.0 : 0.0;
    nearer += found_m + kFarOff_m < truth[i].range_m ? 1.0 : 0.0;
    farther += truth[i].range_m + kFarOff_m < found_m ? 1.0 : 0.0;
    if (is_hit && std::isfinite(found_m)) error_m.push_back(std::abs(found_m - truth[i].range_m));
  }
  const double count = std::max(1.0, static_cast<double>(fidelity.rays));
  fidelity.agreement = agreements / count;
  fidelity.nearer = nearer / count;
  fidelity.farther = farther / count;
  fidelity.median_m = quantile(error_m, 0.5);
  fidelity.p95_m = quantile(error_m, 0.95);
  return fidelity;
}

}  // namespace sightline::lane
