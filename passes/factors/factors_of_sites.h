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

// The map factors of every site at every range (compute_factors.h), block by block of sites: their
// depth images and virtual scans are not kept. Virtual points in no valid ND are counted in a
// warning. Errors: those of compute_factors(), make_factor_world(), cast-rays and cast-scans;
// disk-full or cannot-write (a temporary file).
Result<StoredTable<FactorTable>> factors_of_sites(PassContext& ctx,
                                                  const FactorsOfSitesOptions& options,
                                                  const TiledNds& nds, const TiledSurface& surface,
                                                  const Sites& sites, const SensorProfile& sensor);
inline constexpr Pass kComputeFactors =
    Pass{"compute-factors", 8, "map-factors", "Map factors of each site", &factors_of_sites}
        .in(Stage::kSites)
        .with({.scan_s = 0.022});

}  // namespace sightline
