#include "passes/vehicle/localizer_handle.h"

#include <utility>

namespace sightline {
namespace {

sightline_nd c_nd(const Nd& nd, const MapFrame& frame) {
  const Eigen::Vector3d mean_m = nd.mean_m + frame.origin_world_m;
  const Eigen::Matrix3d& c = nd.covariance_m2;
  return {{mean_m.x(), mean_m.y(), mean_m.z()},
          {c(0, 0), c(0, 1), c(0, 2), c(1, 1), c(1, 2), c(2, 2)},
          nd.point_count,
          0};
}

}  // namespace
}  // namespace sightline

sightline_localizer::sightline_localizer(sightline::VehicleMap opened)
    : map(std::move(opened)), kernel(sightline::kernel_name(sightline::fastest_kernel())) {
  const sightline::WindowOptions options{
      .own = sightline::localizer_named(map.localizer, map.coarse_cells),
      .usual_range_m = map.longest_look_m,
      .mounting_m = map.sensor.T_vehicle_lidar.translation().norm()};
  nds.reserve(map.ndt.nds.size());
  for (const sightline::Nd& nd : map.ndt.nds) nds.push_back(sightline::c_nd(nd, map.ndt.frame));
  std::vector<sightline::Nd> all = std::exchange(map.ndt.nds, {});
  sightline::NdtMap whole = map.ndt;
  whole.nds = std::move(all);
  windows = map.tiles == nullptr
                ? std::make_unique<sightline::MapWindows>(std::move(whole), options)
                : std::make_unique<sightline::MapWindows>(*map.tiles, options);
}

std::unique_ptr<sightline::Workspace> sightline_localizer::take_workspace(
    const sightline::MapWindow& window) const {
  std::unique_ptr<sightline::Workspace> workspace;
  {
    const std::scoped_lock lock(mutex);
    if (!free.empty()) {
      workspace = std::move(free.back());
      free.pop_back();
    }
  }
  if (workspace == nullptr) {
    const sightline::LookMatching matching{window.own, window.samples, map.sensor, map.leaf_m,
                                           map.takes_every_return};
    return std::make_unique<sightline::Workspace>(sightline::Workspace{
        {}, sightline::LookMatcher(matching), {sightline::LookCutter(map.leaf_m), {}}, {}});
  }
  workspace->matcher.use(window.own, window.samples);
  return workspace;
}

void sightline_localizer::give_back(std::unique_ptr<sightline::Workspace> workspace) const {
  const std::scoped_lock lock(mutex);
  free.push_back(std::move(workspace));
}
