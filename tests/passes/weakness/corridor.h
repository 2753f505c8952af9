#pragma once

#include <vector>

#include "formats/map/compiled_map.h"
#include "passes/map/build_ndt.h"
#include "passes/rays/cast_scans.h"
#include "passes/weakness/site_view.h"

// A straight street along x between bare walls, which nothing holds along it. The sensor drives at
// z = 0, y = 0; ground and walls share no cell.

namespace sightline {

inline constexpr double kCorridorLength_m = 80.0;
inline constexpr double kCorridorWall_m = 8.1;  // the walls, at y = -8.1 and 8.1
inline constexpr double kCorridorTop_m = 4.0;
inline constexpr double kCorridorGround_m = -1.9;
inline constexpr double kCorridorEnd_m = 78.1;  // of a wall across the street

// A lattice of 0.1 m, without noise.
inline NdtMap corridor_map(bool has_end_wall) {
  constexpr double kStep_m = 0.1;
  std::vector<Eigen::Vector3d> points_m;
  for (double x_m = 0.05; x_m < kCorridorLength_m; x_m += kStep_m) {
    for (double y_m = -7.95; y_m < 8.0; y_m += kStep_m) {
      points_m.emplace_back(x_m, y_m, kCorridorGround_m);
    }
    for (double z_m = -1.95; z_m < kCorridorTop_m; z_m += kStep_m) {
      points_m.emplace_back(x_m, kCorridorWall_m, z_m);
      points_m.emplace_back(x_m, -kCorridorWall_m, z_m);
    }
  }
  for (double y_m = -7.95; has_end_wall && y_m < 8.0; y_m += kStep_m) {
    for (double z_m = 0.05; z_m < kCorridorTop_m; z_m += kStep_m) {
      points_m.emplace_back(kCorridorEnd_m, y_m, z_m);
    }
  }
  return ndt_from_points(points_m, MapFrame(), BuildNdtOptions(), 1);
}

inline Sites corridor_sites() {
  Sites sites;
  for (int i = 0; i < 5; ++i) {
    Site site;
    site.s_m = 10.0 * i;
    site.p_map_m.x() = 20.0 + 10.0 * i;
    site.T_map_vehicle.translation() = site.p_map_m;
    sites.sites.push_back(site);
  }
  return sites;
}

inline SensorProfile corridor_sensor() {
  SensorProfile sensor;
  for (int beam = -15; beam <= 15; beam += 2) sensor.beam_elevations_deg.push_back(beam);
  sensor.azimuth_step_deg = 0.5;
  return sensor;
}

struct CorridorScene {
  explicit CorridorScene(bool has_end_wall = false) : map(corridor_map(has_end_wall)) {
    const Result<std::vector<SiteView>> seen =
        views_from(ctx, options, nds, sites, {2}, directions);
    SIGHTLINE_CHECK(seen.has_value());
    views = *seen;
  }
  NdtMap map;
  Sites sites = corridor_sites();
  ViewOptions options;
  PassContext ctx;
  std::vector<Eigen::Vector3d> directions = beam_directions(corridor_sensor());
  NearNds nds = nds_near(map, positions_m(sites), 60.0);
  std::vector<SiteView> views;
};

}  // namespace sightline
