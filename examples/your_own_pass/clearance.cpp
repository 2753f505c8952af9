#include "examples/your_own_pass/clearance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "compiler/base/parallel.h"

namespace sightline {
namespace {

bool is_wall(const Nd& nd) {
  constexpr double kLevel = 0.5;  // |z| of a normal 30 degrees off level
  return dimension_class(nd) == 2 && std::abs(nd.eigenvectors(2, 2)) <= kLevel;
}

double clearance_m(const std::vector<Eigen::Vector3d>& walls_m, const Site& site,
                   const MeasureClearanceOptions& options) {
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& wall_m : walls_m) {
    const Eigen::Vector3d offset_m = wall_m - site.p_map_m;
    if (offset_m.z() < options.lowest_m || offset_m.z() > options.highest_m) continue;
    const double distance_m = offset_m.head<2>().norm();
    if (distance_m <= options.reach_m) nearest_m = std::min(nearest_m, distance_m);
  }
  return nearest_m;
}

}  // namespace

std::vector<OptionField> option_fields(MeasureClearanceOptions& options) {
  return {number("reach_m", options.reach_m, "how far to look for walls, m", 1.0, 100.0),
          number("lowest_m", options.lowest_m, "lowest wall that counts, m above the sensor", -10.0,
                 10.0),
          number("highest_m", options.highest_m, "highest wall that counts, m above the sensor",
                 -10.0, 50.0)};
}

Result<SiteColumn> measure_clearance(PassContext& ctx, const MeasureClearanceOptions& options,
                                     const NdtMap& map, const Sites& sites) {
  if (!(map.frame == sites.frame)) {
    return Error{ErrorCode::kMismatchedInputs, "sites and NDT map are in different frames", "", ""};
  }
  std::vector<Eigen::Vector3d> walls_m;
  for (const Nd& nd : map.nds) {
    if (is_wall(nd)) walls_m.push_back(nd.mean_m);
  }
  SiteColumn column{"clearance_m", {}};
  column.values = parallel_map<double>(sites.sites.size(), ctx.threads, [&](std::size_t i) {
    return clearance_m(walls_m, sites.sites[i], options);
  });
  return column;
}

}  // namespace sightline
