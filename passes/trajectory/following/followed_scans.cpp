#include "passes/trajectory/following/followed_scans.h"

namespace sightline {

void Odometry::append(const Pose& T_map_scan, double step_m, bool matched,
                      std::optional<double> scan_overlap) {
  driven_m.push_back(driven_m.empty() ? 0.0 : driven_m.back() + step_m);
  T_map_lidar.push_back(T_map_scan);
  is_matched.push_back(matched);
  is_far.push_back(false);
  piece.push_back(static_cast<std::uint32_t>(piece_starts.size()));
  overlap.push_back(scan_overlap);
  constraint.emplace_back();
}

void Odometry::append_known(const Pose& T_map_scan, bool begins_piece,
                            std::optional<double> scan_overlap) {
  const auto scan = static_cast<std::uint32_t>(piece.size());
  const bool has_step = scan > 0 && !begins_piece;
  if (begins_piece) piece_starts.push_back({scan, true});
  const double step_m =
      has_step ? (T_map_scan.translation() - T_map_lidar.back().translation()).norm() : 0.0;
  append(T_map_scan, step_m, true, scan_overlap);
}

std::vector<std::uint32_t> scans_every(const Odometry& odometry, const ScanRange& range,
                                       double step_m) {
  std::vector<std::uint32_t> scans;
  double next_m = odometry.driven_m[range.begin];
  for (std::uint32_t k = range.begin; k < range.end; ++k) {
    if (odometry.driven_m[k] < next_m) continue;
    next_m = odometry.driven_m[k] + step_m;
    scans.push_back(k);
  }
  return scans;
}

std::vector<ScanRange> ranges_of(const std::vector<std::uint32_t>& piece) {
  std::vector<ScanRange> ranges;
  for (std::uint32_t k = 0; k < piece.size(); ++k) {
    if (k == 0 || piece[k] != piece[k - 1]) ranges.push_back({k, k});
    ranges.back().end = k + 1;
  }
  return ranges;
}

}  // namespace sightline
