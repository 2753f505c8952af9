#include "passes/localize/measure_site.h"

#include <algorithm>
#include <cmath>

#include "formats/base/portable_math.h"
#include "formats/base/random.h"
#include "formats/base/statistics.h"
#include "formats/base/stopwatch.h"
#include "passes/matching/match_starts.h"

namespace sightline {
namespace {

void add_run(const MatchResult& result, const ReferencedScan& scan, double count, ErrorRow& row) {
  const Pose T_reference_found =
      scan.T_map_reference.inverse(Eigen::Isometry) * result.T_map_sensor;
  const Eigen::Vector3d off_m = T_reference_found.translation();
  const double yaw_rad = portable_atan2(T_reference_found(1, 0), T_reference_found(0, 0));
  const auto work = static_cast<double>(result.work);
  row.mean_m += off_m.norm() / count;
  row.longitudinal_m += std::abs(off_m.x()) / count;
  row.lateral_m += std::abs(off_m.y()) / count;
  row.yaw_rad += std::abs(yaw_rad) / count;
  row.lost_share += (off_m.norm() > kLostBeyond_m ? 1.0 : 0.0) / count;
  row.from_given_m +=
      (result.T_map_sensor.translation() - scan.T_map_given.translation()).norm() / count;
  row.mean_iterations += result.iterations / count;
  row.mean_work += work / count;
  row.max_work = std::max(row.max_work, work);
}

// All offsets at one look. What it takes to cut the scan is shared by the runs here, and so is what
// one takes over from another, but a vehicle pays it for each scan: it counts in full for each run.
ErrorRow measure_row(const std::vector<InitialOffset>& offsets, const Look& look,
                     const ReferencedScan& scan, SiteLocalizer& localizer) {
  const Pose& T_map_reference = scan.T_map_reference;
  const double cut_begin_ms = thread_cpu_ms();
  localizer.take(scan.scan, look);
  const double cut_ms = thread_cpu_ms() - cut_begin_ms;
  ErrorRow row;
  const auto count = static_cast<double>(offsets.size());
  std::vector<double> errors_m;
  for (const InitialOffset& offset : offsets) {
    const double begin_ms = thread_cpu_ms();
    const MatchResult result = localizer.match(T_map_reference * start_pose(offset));
    const double time_ms = cut_ms + thread_cpu_ms() - begin_ms + localizer.taken_over_ms();
    add_run(result, scan, count, row);
    row.mean_time_ms += time_ms / count;
    row.max_time_ms = std::max(row.max_time_ms, time_ms);
    errors_m.push_back((result.T_map_sensor.translation() - T_map_reference.translation()).norm());
  }
  row.point_count = static_cast<std::uint32_t>(localizer.point_count());
  // A sum of shares of n may end an ulp above 1.
  row.lost_share = std::min(row.lost_share, 1.0);
  std::sort(errors_m.begin(), errors_m.end());
  row.median_m = quantile_of_sorted(errors_m, 0.5);
  row.p90_m = quantile_of_sorted(errors_m, 0.9);
  row.max_m = errors_m.back();
  return row;
}

Pose reference_pose(const SiteMeasuring& measuring, SiteLocalizer& localizer, const Scan& scan,
                    const Pose& T_map_given) {
  if (measuring.reference == ErrorReference::kKnownPose) return T_map_given;
  localizer.take(scan, every_return(measuring.drive.sensor.max_range_m));
  return localizer.match(T_map_given).T_map_sensor;
}

}  // namespace

void measure_scan(const std::vector<InitialOffset>& offsets, const std::vector<Look>& looks,
                  const ReferencedScan& scan, SiteLocalizer& localizer,
                  std::vector<ErrorRow>& rows) {
  for (const Look& look : looks) rows.push_back(measure_row(offsets, look, scan, localizer));
}

Result<void> measure_site(const SiteMeasuring& measuring, SiteLocalizer& localizer,
                          std::size_t scan_index, SiteRows& rows) {
  SIGHTLINE_ASSIGN(const Scan scan, measuring.drive.store->read(scan_index));
  const Pose& T_map_given = measuring.trajectory.poses[scan_index].T_map_vehicle;
  localizer.go_to(T_map_given.translation(),
                  mix(measuring.seed, measuring.drive.scans[scan_index].recording_index));
  const ReferencedScan referenced{scan, reference_pose(measuring, localizer, scan, T_map_given),
                                  T_map_given};
  measure_scan(measuring.offsets, measuring.looks, referenced, localizer, rows.rows);
  measure_scan(measuring.offsets, measuring.samples, referenced, localizer, rows.samples);
  return {};
}

}  // namespace sightline
