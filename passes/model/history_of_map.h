#pragma once

#include <vector>

#include "formats/annotation/measured_drives.h"
#include "formats/annotation/measured_error.h"
#include "formats/annotation/sites.h"
#include "formats/drive/sensor_profile.h"
#include "formats/map/compiled_map.h"
#include "passes/pass/pass.h"

// What drives found in a map before it is annotated anew, so that nothing measured is thrown away.

namespace sightline {

struct HistoryOfMapOptions {
  double site_radius_m = 1.0;  // a site that was measured speaks for those no farther from it
};
std::vector<OptionField> option_fields(HistoryOfMapOptions& options);

// The drives that the map's predictions were told of (passes/model/forest/measured_columns.h), at
// other sites of the same map: each site takes the rows of the nearest that the drive measured.
// `like` says by which looks and which localizer errors are told here. A drive that was measured by
// others, or by another sensor, is left out, and a warning says so. None where the map keeps none.
// Their numbers are those behind `like`, a drive or nothing: no recording is named for them. Error:
// mismatched-inputs where the sites are in another frame.
Result<MeasuredDrives> history_of_map(PassContext& ctx, const HistoryOfMapOptions& options,
                                      const CompiledMap& map, const Sites& sites,
                                      const SensorProfile& sensor, const MeasuredError& like);
inline constexpr Pass kHistoryOfMap = Pass{"history-of-map", 1, "measured-drives",
                                           "What drives found in a map before", &history_of_map}
                                          .in(Stage::kLearn);

// The same behind what localization drives found now: one, which is `now`, or several.
Result<MeasuredDrives> history_of_map_and_drive(PassContext& ctx,
                                                const HistoryOfMapOptions& options,
                                                const CompiledMap& map, const Sites& sites,
                                                const SensorProfile& sensor,
                                                const MeasuredError& now);
inline constexpr Pass kHistoryOfMapAndDrive = variant_of(kHistoryOfMap, &history_of_map_and_drive);
Result<MeasuredDrives> history_of_map_and_drives(PassContext& ctx,
                                                 const HistoryOfMapOptions& options,
                                                 const CompiledMap& map, const Sites& sites,
                                                 const SensorProfile& sensor,
                                                 const MeasuredDrives& now);
inline constexpr Pass kHistoryOfMapAndDrives =
    variant_of(kHistoryOfMap, &history_of_map_and_drives);

}  // namespace sightline
