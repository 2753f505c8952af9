#pragma once

#include <vector>

#include "formats/annotation/measured_error.h"
#include "formats/annotation/sites.h"
#include "formats/drive/sensor_profile.h"
#include "formats/surroundings/ndt_map.h"
#include "formats/surroundings/surface.h"
#include "formats/tables/stored_table.h"
#include "passes/localize/measure_error.h"
#include "passes/pass/pass.h"

namespace sightline {

struct SimulateErrorOptions {
  MeasureErrorOptions matching;  // how scans are matched: those of measure-error
  double range_noise_m = 0.02;   // of a return, along its ray: standard deviation
  double hidden_deg = 90.0;      // of azimuth that traffic hides, another side at every site
  double missing_share = 0.05;   // of returns, which fail to come
  double relief_m = 0.02;        // by which the surface of that day differs: standard deviation
};
std::vector<OptionField> option_fields(SimulateErrorOptions& options);

// How far off the matcher ends at places without a drive: at each site the sensor's own beams are
// cast on the surface, disturbed as a scan of another day would be, and matched as measure-error
// matches scans, against the place at which they were cast (schemas/definitions.md, "Annotating a
// finished map"). The drive is called "simulated", the reference is kSimulated. Surface and map
// come from the same points, so that this is optimistic. Errors: mismatched-inputs (map, surface
// and sites in different frames), empty-map, bad-value (pcl-ndt, which no simulation can stand
// for), cannot-read, disk-full or cannot-write (a temporary file).
Result<ByFamily<StoredTable<MeasuredError>>> simulate_error(PassContext& ctx,
                                                            const SimulateErrorOptions& options,
                                                            const TiledSurface& surface,
                                                            const TiledNds& nds, const Sites& sites,
                                                            const SensorProfile& sensor);
inline constexpr Pass kSimulateError =
    Pass{"simulate-error", 5, "simulated", "Localization error of simulated scans", &simulate_error}
        .in(Stage::kSites);

}  // namespace sightline
