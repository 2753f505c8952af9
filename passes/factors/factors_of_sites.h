#pragma once

#include <vector>

#include "formats/annotation/factor_table.h"
#include "formats/annotation/sites.h"
#include "formats/drive/sensor_profile.h"
#include "formats/surroundings/ndt_map.h"
#include "formats/surroundings/surface.h"
#include "formats/tables/stored_table.h"
#include "passes/pass/default_looks.h"
#include "passes/pass/pass.h"
#include "passes/rays/cast_rays.h"
#include "passes/rays/cast_scans.h"

namespace sightline {

struct FactorsOfSitesOptions {
  std::vector<double> ranges_m = default_ranges_m();
  CastRaysOptions rays;    // those of cast-rays
  CastScansOptions scans;  // those of cast-scans
};
std::vector<OptionField> option_fields(FactorsOfSitesOptions& options);

// The map factors of every site at every range (compute_factors.h). What a site sees of the surface
// is cast for its block of sites and forgotten with it: of a whole map, depth images and virtual
// scans would be most of what a compile keeps. Each block is a part of the work. Virtual points in
// no valid ND are counted in a warning. Errors: bad-value (ranges that do not ascend from above 0),
// mismatched-inputs (frames that differ, or rays that end before the longest range), and those of
// cast-rays and cast-scans; disk-full or cannot-write (a temporary file).
Result<StoredTable<FactorTable>> factors_of_sites(PassContext& ctx,
                                                  const FactorsOfSitesOptions& options,
                                                  const TiledNds& nds, const TiledSurface& surface,
                                                  const Sites& sites, const SensorProfile& sensor);
inline constexpr Pass kComputeFactors =
    Pass{"compute-factors", 8, "map-factors", "Map factors", &factors_of_sites}
        .in(Stage::kSites)
        .with({.scan_s = 0.022});

}  // namespace sightline
