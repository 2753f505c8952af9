#pragma once

#include <string>
#include <vector>

#include "formats/map/compiled_map.h"
#include "passes/map/build_ndt.h"
#include "passes/rays/cast_scans.h"
#include "passes/weakness/site_view.h"
#include "tests/support/toy_world.h"

// A straight street between bare walls, which nothing holds along it.

namespace sightline {

inline constexpr int kCorridorLength_m = 80;
inline constexpr int kCorridorHalfWidth_m = 8;

// The walls at y = 1 and 2 kCorridorHalfWidth_m + 2, sites every 10 m in the middle, from x = 20.5.
// `crosswall_at` > 0: a wall across the end of the street, from x = 78.
inline ToyWorld corridor(bool has_end_wall = false) {
  const auto length = static_cast<std::size_t>(kCorridorLength_m);
  std::string open(length, '.');
  if (has_end_wall) open.replace(length - 2, 2, "##");
  std::string driven = open;
  for (std::size_t x = 20; x <= 60; x += 10) driven[x] = '@';
  std::string text = std::string(length, '#') + "\n";
  for (int y = 0; y < 2 * kCorridorHalfWidth_m + 1; ++y) {
    text += (y == kCorridorHalfWidth_m ? driven : open) + "\n";
  }
  return draw_world(text + std::string(length, '#') + "\n");
}

inline SensorProfile corridor_sensor() {
  SensorProfile sensor;
  for (int beam = -15; beam <= 15; beam += 2) sensor.beam_elevations_deg.push_back(beam);
  sensor.azimuth_step_deg = 0.5;
  return sensor;
}

inline NdtMap nds_of(const ToyWorld& world) {
  PassContext ctx;
  const Result<NdtMap> map = build_ndt(ctx, {}, world.points);
  SIGHTLINE_CHECK(map.has_value());
  return *map;
}

// What the passes of this folder take, of the site in the middle.
struct CorridorScene {
  explicit CorridorScene(bool has_end_wall = false)
      : world(corridor(has_end_wall)), map(nds_of(world)) {
    const Result<std::vector<SiteView>> seen =
        views_from(ctx, options, nds, world.sites, {2}, directions);
    SIGHTLINE_CHECK(seen.has_value());
    views = *seen;
  }
  ToyWorld world;
  NdtMap map;
  ViewOptions options;
  PassContext ctx;
  std::vector<Eigen::Vector3d> directions = beam_directions(corridor_sensor());
  NearNds nds = nds_near(map, positions_m(world.sites), 60.0);
  std::vector<SiteView> views;
};

}  // namespace sightline
