#pragma once

#include <vector>

#include "formats/annotation/measured_drives.h"
#include "formats/annotation/measured_error.h"
#include "formats/annotation/sites.h"
#include "formats/drive/sensor_profile.h"
#include "formats/map/compiled_map.h"
#include "passes/pass/pass.h"

// What drives measured in a map before it is annotated anew, so that it is not lost.

namespace sightline {

struct HistoryOfMapOptions {
  double site_radius_m = 1.0;  // a site that was measured speaks for those no farther from it
};
std::vector<OptionField> option_fields(HistoryOfMapOptions& options);

// The drives that were inputs of the map's predictions (passes/model/forest/measured_columns.h), at
// other sites of the same map: each site takes the rows of the nearest one that the drive measured.
// They follow the drives that are localized in the map now: those of `now` where it is given, else
// the drive of `measured`, or none where `measured` is simulated. All are by the looks and the
// localizer of these, and by `sensor`: a drive of the map that was measured by others is left out,
// and a warning says so. No recording is named for the drives of the map. Error: mismatched-inputs
// where the sites are in another frame.
Result<MeasuredDrives> history_of_map(PassContext& ctx, const HistoryOfMapOptions& options,
                                      const CompiledMap& map, const Sites& sites,
                                      const SensorProfile& sensor,
                                      const ByFamily<MeasuredError>& measured,
                                      const MeasuredDrives* now);
inline constexpr Pass kHistoryOfMap = Pass{"history-of-map", 2, "measured-drives",
                                           "Errors measured in an earlier map", &history_of_map}
                                          .in(Stage::kLearn);

}  // namespace sightline
