#include <utility>

#include "passes/localize/measure_error.h"
#include "passes/pass/scan_selection.h"

namespace sightline {

StartPattern starts_of(const MeasureErrorOptions& options) {
  StartPattern starts = options.starts;
  if (starts.count == 0) starts.count = options.localizer == LocalizerKind::kPclNdt ? 3 : 12;
  return starts;
}

MatchStarts match_starts_of(const MeasureErrorOptions& options) {
  return {initial_offsets(starts_of(options)), tracking_offsets(options.tracking),
          options.tracking};
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
                   "looks that take a sample, in order of matching time; paper: none")),
      shared(flag("every_return", options.every_return, "ranges use all returns, as in the paper")),
      shared(flag("in_small_map", options.in_small_map, "the NDs are those of a small map")),
      shared(number("leaf_m", options.leaf_m, "voxel size for subsampling a scan, m", 0.05, 10.0)),
      integer("offset_count", options.starts.count,
              "start poses per match; 0: 12, or 3 with pcl-ndt", 0, 1000),
      integer("site_step", options.site_step,
              "measure every n-th site; 0: all sites, or every tenth with pcl-ndt", 0, 100),
      number("offset_radius_m", options.starts.radius_m, "radius of the disc of start poses, m",
             0.0, 10.0),
      number("offset_yaw_deg", options.starts.yaw_deg,
             "largest yaw offset of a start pose, degrees", 0.0, 90.0),
      number("offset_z_m", options.starts.z_m, "largest height offset of a start pose, m", 0.0,
             10.0),
      integer("tracking_count", options.tracking.count,
              "start poses of a vehicle that tracks per match; 0: none, else at least 5", 0, 1000),
      number("tracking_horizontal_m", options.tracking.horizontal_m,
             "tracking starts: standard deviation of each horizontal axis, m", 0.0, 10.0),
      number("tracking_height_m", options.tracking.height_m,
             "tracking starts: standard deviation of the height, m", 0.0, 10.0),
      number("tracking_yaw_deg", options.tracking.yaw_deg,
             "tracking starts: standard deviation of the heading, degrees", 0.0, 90.0),
      scans_option(options.scans),
      number("site_radius_m", options.site_radius_m, "largest distance from a site to its scan, m",
             0.01, 100.0),
      choice(
          "reference", options.reference,
          "reference of the errors: the known pose (else full-range), or the match at full range",
          {"known", "full-range"}),
      choice("localizer", options.localizer,
             "matcher of the scans (schemas/definitions.md, Localizers); pcl-ndt: NDT of PCL with "
             "Autoware's parameters",
             localizer_names()),
      integer("coarse_cells", options.coarse_cells,
              "match first on cells that are larger by this factor; 1: off", 1, 16),
      shared(flag("may_be_elsewhere", options.may_be_elsewhere, "allow drives that pass no site"))};
}

std::vector<OptionField> with_matching(std::vector<OptionField> own,
                                       MeasureErrorOptions& matching) {
  for (OptionField& field : option_fields(matching)) own.push_back(shared(std::move(field)));
  return own;
}

}  // namespace sightline
