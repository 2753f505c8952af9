#include "passes/map/count_removed.h"

#include <algorithm>
#include <limits>

#include "formats/base/parallel.h"
#include "formats/grid/point_grid.h"

namespace sightline {
namespace {

constexpr double kEvery_m = 2.0;
constexpr double kAround_m = 5.0;

// The scans that are counted.
std::vector<std::size_t> scans_along(const std::vector<PlacedScan>& scans) {
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const Eigen::Vector3d at_m = scans[i].T_map_lidar.translation();
    const bool is_far = chosen.empty() ||
                        (at_m - scans[chosen.back()].T_map_lidar.translation()).norm() >= kEvery_m;
    if (is_far) chosen.push_back(i);
  }
  return chosen;
}

struct Removed {
  double count = 0.0;
  double of = 0.0;  // returns
};

Result<Removed> removed_of(const SurfacePointReader& reader, std::size_t scan) {
  SIGHTLINE_ASSIGN(const ReturnsInMap returns, reader.all(scan));
  const auto moved = std::ranges::count(returns.has_moved, 1);
  return Removed{static_cast<double>(moved), static_cast<double>(returns.points_m.size())};
}

}  // namespace

Result<SiteColumn> count_removed(PassContext& ctx, const NoOptions& /*options*/,
                                 const SurfacePoints& points, const Sites& sites) {
  const std::vector<std::size_t> scans = scans_along(points.scans);
  const SurfacePointReader reader(points, scans);
  SIGHTLINE_ASSIGN(const std::vector<Removed> removed,
                   parallel_results<Removed>(scans.size(), ctx.threads, [&](std::size_t i) {
                     return removed_of(reader, scans[i]);
                   }));
  std::vector<Eigen::Vector3d> places_m;
  for (const std::size_t scan : scans) {
    places_m.push_back(points.scans[scan].T_map_lidar.translation());
  }
  const PointGrid grid(places_m);
  SiteColumn column{std::string(kRemovedShare), "", {}};
  for (const Site& site : sites.sites) {
    Removed around;
    for (const NearPoint& near : grid.within(site.p_map_m, kAround_m)) {
      around.count += removed[near.index].count;
      around.of += removed[near.index].of;
    }
    column.values.push_back(around.of > 0.0 ? static_cast<float>(around.count / around.of)
                                            : std::numeric_limits<float>::infinity());
  }
  return column;
}

}  // namespace sightline
