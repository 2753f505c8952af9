#pragma once

#include <vector>

#include "formats/annotation/sites.h"
#include "formats/drive/sensor_profile.h"
#include "formats/surroundings/site_views.h"
#include "formats/surroundings/surface.h"
#include "passes/pass/pass.h"
#include "passes/rays/surface_caster.h"

namespace sightline {

struct CastScansOptions {
  double near_m = 0.5;
  double longest_range_m = 50.0;
  double leaf_m = 1.0;  // the localizer's
};
std::vector<OptionField> option_fields(CastScansOptions& options);

// Where the beams of a level sensor that turns point at every `stride`-th azimuth step, the first
// along map +x; unit length, beam by beam, so that neighbours in the list are neighbours in the
// world. Of a sensor that does not see all round AzimuthView computes which of them it has at a
// site.
std::vector<Eigen::Vector3d> beam_directions(const SensorProfile& sensor, int stride = 1);

// Which azimuth steps are cast, every one or every n-th: the most for which neighbouring rays are
// no more than 0.4 leaf_m apart at the longest range. What lies between them would end in the same
// voxels.
int azimuth_stride(const CastScansOptions& options, const SensorProfile& sensor);

// What the localizing sensor would measure at every site: each of its beams at the azimuth steps of
// azimuth_stride(), the first along map +x, that lies in its view, cast level from p on the surface
// and subsampled on the localizer's voxel grid. Definition: schemas/definitions.md, "Factors from a
// virtual scan". Errors: mismatched-inputs (surface and sites in different frames), bad-value (near
// beyond far), cannot-read.
Result<VirtualScans> cast_scans(PassContext& ctx, const CastScansOptions& options,
                                const TiledSurface& surface, const Sites& sites,
                                const SensorProfile& sensor);
// The same from the sites of one block. The scene reaches as far as the options.
Result<VirtualScans> cast_scans_in_block(const CastScansOptions& options, const BlockScene& scene,
                                         const SensorProfile& sensor, int threads);
inline constexpr Pass kCastScans =
    Pass{"cast-scans", 4, "virtual-scans", "Virtual scans of each site", &cast_scans}
        .in(Stage::kSites)
        .with({.scan_s = 0.006, .million_points_s = 0.15});

}  // namespace sightline
