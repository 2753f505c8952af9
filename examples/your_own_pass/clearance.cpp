#include "examples/your_own_pass/clearance.h"

#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "formats/base/parallel.h"
#include "formats/grid/point_grid.h"

namespace sightline {
namespace {

bool is_wall(const Nd& nd) {
  constexpr double kLevel = 0.5;  // |z| of a normal 30 degrees off level
  return dimension_class(nd) == 2 && std::abs(nd.eigenvectors(2, 2)) <= kLevel;
}

// Walls by where they stand in the plane, and how high.
struct Walls {
  PointGrid places;
  std::vector<double> heights_m;
};

Walls walls_of(const NdtMap& map) {
  std::vector<Eigen::Vector3d> places_m;
  std::vector<double> heights_m;
  for (const Nd& nd : map.nds) {
    if (!is_wall(nd)) continue;
    places_m.emplace_back(nd.mean_m.x(), nd.mean_m.y(), 0.0);
    heights_m.push_back(nd.mean_m.z());
  }
  return {PointGrid(places_m), std::move(heights_m)};
}

double clearance_m(const Walls& walls, const Eigen::Vector3d& p_map_m,
                   const MeasureClearanceOptions& options) {
  const auto counts = [&](const NearPoint& wall) {
    const double above_m = walls.heights_m[wall.index] - p_map_m.z();
    return above_m >= options.lowest_m && above_m <= options.highest_m;
  };
  const std::optional<NearPoint> nearest =
      walls.places.nearest({p_map_m.x(), p_map_m.y(), 0.0}, options.reach_m, counts);
  return nearest ? nearest->distance_m : std::numeric_limits<double>::infinity();
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
    return Error{ErrorCode::kMismatchedInputs, "sites and NDT map are in different frames"};
  }
  const Walls walls = walls_of(map);
  SiteColumn column{"clearance_m", "m", {}};
  column.values = parallel_map<float>(sites.sites.size(), ctx.threads, [&](std::size_t i) {
    return static_cast<float>(clearance_m(walls, sites.sites[i].p_map_m, options));
  });
  return column;
}

}  // namespace sightline
