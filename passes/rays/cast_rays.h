#pragma once

#include <vector>

#include "formats/annotation/sites.h"
#include "formats/drive/sensor_profile.h"
#include "formats/surroundings/site_views.h"
#include "formats/surroundings/surface.h"
#include "passes/pass/pass.h"
#include "passes/rays/surface_caster.h"

namespace sightline {

// The localizing sensor's field, in cells of one ray each.
struct CastRaysOptions {
  int azimuth_count = 360;
  int elevation_count = 31;
  double first_elevation_deg = -15.0;
  double elevation_step_deg = 1.0;
  double near_m = 0.5;
  double longest_range_m = 50.0;
};
std::vector<OptionField> option_fields(CastRaysOptions& options);

// What a level sensor would see of the surface from every site: one ray a cell that lies in its
// azimuth view, in map axes, both faces and the ground count. Definition: schemas/definitions.md,
// `occupancy_ratio`.
// Errors: mismatched-inputs (surface and sites in different frames), bad-value (near beyond far, or
// elevations beyond the poles), cannot-read.
Result<DepthImages> cast_rays(PassContext& ctx, const CastRaysOptions& options,
                              const TiledSurface& surface, const Sites& sites,
                              const SensorProfile& sensor);
// The same from the sites of one block. The scene reaches as far as the options.
Result<DepthImages> cast_rays_in_block(const CastRaysOptions& options, const BlockScene& scene,
                                       const SensorProfile& sensor, int threads);
inline constexpr Pass kCastRays =
    Pass{"cast-rays", 3, "depth", "Depth images of each site", &cast_rays}
        .in(Stage::kSites)
        .with({.scan_s = 0.004});

}  // namespace sightline
