#include <utility>

#include "passes/localize/measure_error.h"
#include "passes/pass/scan_selection.h"

namespace sightline {

StartPattern starts_of(const MeasureErrorOptions& options) {
  StartPattern starts = options.starts;
  if (starts.count == 0) starts.count = options.localizer == LocalizerKind::kPclNdt ? 3 : 12;
  return starts;
}

int site_step_of(const MeasureErrorOptions& options) {
  if (options.site_step > 0) return options.site_step;
  return options.localizer == LocalizerKind::kPclNdt ? 10 : 1;
}

std::vector<OptionField> option_fields(MeasureErrorOptions& options) {
  return {
      shared(numbers("ranges_m", options.ranges_m, "ranges at which scans are cropped, m", 1.0,
                     1000.0)),
      shared(looks("looks", options.looks,
                   "looks that take a sample, from the cheapest to the dearest; paper: none")),
      shared(flag("every_return", options.every_return,
                  "ranges take every return, as the paper does")),
      shared(number("leaf_m", options.leaf_m, "voxel of the subsampled scan, m", 0.05, 10.0)),
      integer("offset_count", options.starts.count,
              "starts of the matcher; 0: 12, and 3 of pcl-ndt", 0, 1000),
      integer("site_step", options.site_step,
              "every so many sites one is measured; 0: each, and every tenth by pcl-ndt", 0, 100),
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
      choice("localizer", options.localizer,
             "how scans are matched (definitions: Localizers); pcl-ndt: PCL's own NDT with "
             "Autoware's numbers",
             localizer_names()),
      integer("coarse_cells", options.coarse_cells,
              "matches first on cells so many times as long as the map's; 1 does not", 1, 16),
      shared(flag("may_be_elsewhere", options.may_be_elsewhere,
                  "the drive need not come near any site"))};
}

std::vector<OptionField> with_matching(std::vector<OptionField> own,
                                       MeasureErrorOptions& matching) {
  for (OptionField& field : option_fields(matching)) own.push_back(shared(std::move(field)));
  return own;
}

}  // namespace sightline
