#include <cmath>
#include <numbers>

#include "compiler/base/portable_math.h"
#include "passes/measure_error.h"
#include "passes/scan_selection.h"

namespace sightline {
namespace {

constexpr double kGoldenAngle_rad = 2.399963229728653;

// 0 .. count-1 to -1 .. 1 in even steps.
double evenly(int step, int count) { return count > 1 ? 2.0 * step / (count - 1) - 1.0 : 0.0; }

}  // namespace

std::vector<OptionField> option_fields(MeasureErrorOptions& options) {
  return {
      numbers("ranges_m", options.ranges_m, "ranges at which scans are cropped, m", 1.0, 1000.0),
      number("leaf_m", options.leaf_m, "voxel of the subsampled scan, m", 0.05, 10.0),
      integer("offset_count", options.offset_count, "starts of the matcher", 1, 1000),
      number("offset_radius_m", options.offset_radius_m, "starts lie in this disc, m", 0.0, 10.0),
      number("offset_yaw_deg", options.offset_yaw_deg, "largest yaw of a start, degrees", 0.0,
             90.0),
      number("offset_z_m", options.offset_z_m, "largest height of a start, m", 0.0, 10.0),
      scans_option(options.scans),
      number("site_radius_m", options.site_radius_m, "a site's scan lies no farther from it, m",
             0.01, 100.0),
      choice("reference", options.reference,
             "what errors are measured against: the known pose, or the match at full range",
             {"known", "full-range"}),
      choice("localizer", options.localizer, "how scans are matched (definitions: Localizers)",
             {"plain", "annealed", "searching"}),
      integer("coarse_cells", options.coarse_cells,
              "matches first on cells so many times as long as the map's; 1 does not", 1, 16)};
}

std::vector<InitialOffset> initial_offsets(const MeasureErrorOptions& options) {
  const int count = options.offset_count;
  std::vector<InitialOffset> offsets;
  for (int k = 0; k < count; ++k) {
    const double radius_m = options.offset_radius_m * std::sqrt((k + 0.5) / count);
    const double angle_rad = kGoldenAngle_rad * k;
    InitialOffset offset;
    const SinCos direction = portable_sin_cos(angle_rad);
    offset.x_m = radius_m * direction.cos;
    offset.y_m = radius_m * direction.sin;
    offset.z_m = options.offset_z_m * evenly(7 * k % count, count);
    offset.yaw_rad =
        options.offset_yaw_deg * evenly(5 * k % count, count) * std::numbers::pi / 180.0;
    offsets.push_back(offset);
  }
  return offsets;
}

Pose start_pose(const InitialOffset& offset) {
  Pose pose = Pose::Identity();
  const SinCos yaw = portable_sin_cos(offset.yaw_rad);
  pose.linear() << yaw.cos, -yaw.sin, 0.0, yaw.sin, yaw.cos, 0.0, 0.0, 0.0, 1.0;
  pose.translation() = Eigen::Vector3d(offset.x_m, offset.y_m, offset.z_m);
  return pose;
}

}  // namespace sightline
