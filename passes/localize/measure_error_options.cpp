#include "passes/localize/measure_error.h"
#include "passes/pass/scan_selection.h"

namespace sightline {
std::vector<OptionField> option_fields(MeasureErrorOptions& options) {
  return {
      shared(numbers("ranges_m", options.ranges_m, "ranges at which scans are cropped, m", 1.0,
                     1000.0)),
      shared(number("leaf_m", options.leaf_m, "voxel of the subsampled scan, m", 0.05, 10.0)),
      integer("offset_count", options.starts.count, "starts of the matcher", 1, 1000),
      number("offset_radius_m", options.starts.radius_m, "starts lie in this disc, m", 0.0, 10.0),
      number("offset_yaw_deg", options.starts.yaw_deg, "largest yaw of a start, degrees", 0.0,
             90.0),
      number("offset_z_m", options.starts.z_m, "largest height of a start, m", 0.0, 10.0),
      scans_option(options.scans),
      number("site_radius_m", options.site_radius_m, "a site's scan lies no farther from it, m",
             0.01, 100.0),
      choice("reference", options.reference,
             "what errors are measured against: the known pose (full-range where there is none), "
             "or the match at full range",
             {"known", "full-range"}),
      choice("localizer", options.localizer, "how scans are matched (definitions: Localizers)",
             {"plain", "annealed", "searching"}),
      integer("coarse_cells", options.coarse_cells,
              "matches first on cells so many times as long as the map's; 1 does not", 1, 16),
      shared(flag("is_mapping_drive", options.is_mapping_drive,
                  "the drive's poses made the map and are its reference"))};
}

}  // namespace sightline
