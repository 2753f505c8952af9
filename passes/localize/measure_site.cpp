#include "passes/localize/measure_site.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "formats/base/check.h"
#include "formats/base/portable_math.h"
#include "formats/base/random.h"
#include "formats/base/statistics.h"
#include "formats/base/stopwatch.h"
#include "passes/localize/pcl/pcl_ndt.h"
#include "passes/matching/look_cutter.h"
#include "passes/matching/match_starts.h"
#include "passes/matching/scan_cutter.h"

namespace sightline {
namespace {

// Of an end relative to the reference.
double yaw_of(const Pose& T_reference_found) {
  return portable_atan2(T_reference_found(1, 0), T_reference_found(0, 0));
}

AxisErrors axes_of(const Pose& T_reference_found) {
  const Eigen::Vector3f off_m = T_reference_found.translation().cast<float>();
  return {off_m.x(), off_m.y(), off_m.z(), static_cast<float>(yaw_of(T_reference_found))};
}

Pose from_reference(const MatchResult& result, const ReferencedScan& scan) {
  return scan.T_map_reference.inverse(Eigen::Isometry) * result.T_map_sensor;
}

void add_run(const MatchResult& result, const ReferencedScan& scan, double count, ErrorRow& row) {
  const Pose T_reference_found = from_reference(result, scan);
  const Eigen::Vector3d off_m = T_reference_found.translation();
  const double yaw_rad = yaw_of(T_reference_found);
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

// What it takes to cut a scan is shared by the runs here, and so is what one takes over from
// another, but a vehicle pays it for each scan: it counts in full for each run.
struct TimedMatch {
  MatchResult result;
  double time_ms = 0.0;
};
template <class Match>
TimedMatch match_timed(double cut_ms, const SiteLocalizer& localizer, const Match& match) {
  const double begin_ms = thread_cpu_ms();
  const MatchResult result = match();
  return {result, cut_ms + thread_cpu_ms() - begin_ms + localizer.taken_over_ms()};
}

// All acquiring starts at one look.
ErrorRow measure_row(const std::vector<InitialOffset>& starts, const ReferencedScan& scan,
                     double cut_ms, SiteLocalizer& localizer) {
  const Pose& T_map_reference = scan.T_map_reference;
  ErrorRow row;
  const auto count = static_cast<double>(starts.size());
  std::vector<double> errors_m;
  std::vector<AxisErrors> ends;
  for (const InitialOffset& start : starts) {
    const auto [result, time_ms] = match_timed(
        cut_ms, localizer, [&] { return localizer.match(T_map_reference * start_pose(start)); });
    add_run(result, scan, count, row);
    ends.push_back(axes_of(from_reference(result, scan)));
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
  row.directions = direction_errors(starts, ends);
  return row;
}

// All tracking starts at the look taken last. Appends their ends.
void measure_tracking(const MatchStarts& starts, const ReferencedScan& scan, double cut_ms,
                      SiteLocalizer& localizer, MeasuredRows& rows) {
  ErrorRow& row = rows.rows.back();
  const auto count = static_cast<double>(starts.tracking.size());
  KnownStart known;
  known.covariance = tracking_covariance(starts.tracking_pattern, scan.T_map_reference.linear());
  for (const InitialOffset& start : starts.tracking) {
    known.T_map_vehicle = scan.T_map_reference * start_pose(start);
    const auto [result, time_ms] =
        match_timed(cut_ms, localizer, [&] { return localizer.match_known(known); });
    row.tracking_work += static_cast<double>(result.work) / count;
    row.tracking_time_ms += time_ms / count;
    rows.tracking_ends.push_back(axes_of(from_reference(result, scan)));
  }
}

Pose reference_pose(const SiteMeasuring& measuring, SiteLocalizer& localizer, const Scan& scan,
                    const Pose& T_map_given) {
  if (measuring.reference == ErrorReference::kKnownPose) return T_map_given;
  localizer.take(scan, every_return(measuring.drive.sensor.max_range_m));
  return localizer.match(T_map_given).T_map_sensor;
}

class OwnSiteLocalizer : public SiteLocalizer {
 public:
  explicit OwnSiteLocalizer(const SiteLocalizerInputs& inputs)
      : matcher_({inputs.own, inputs.of_samples, inputs.sensor, inputs.choice.leaf_m,
                  inputs.choice.takes_every_return, /*shares_climbs=*/true}),
        structures_(inputs.structures) {}
  void go_to(const Eigen::Vector3d& /*p_map_m*/, std::uint64_t /*seed*/) override {}
  void take(const Scan& scan, const Look& look) override { matcher_.take(scan, look); }
  MatchResult match(const Pose& T_map_start) override { return matcher_.match(T_map_start); }
  MatchResult match_known(const KnownStart& start) override {
    SIGHTLINE_CHECK(structures_ != nullptr);
    MatchResult result = matcher_.match(start.T_map_vehicle, search_of_start_m(start.covariance));
    result.T_map_sensor = end_of_match(result, matcher_.scan(), &start, *structures_,
                                       default_information_scale(), observer_)
                              .estimate.T_map_vehicle;
    return result;
  }
  [[nodiscard]] std::size_t point_count() const override { return matcher_.point_count(); }
  [[nodiscard]] double taken_over_ms() const override { return matcher_.taken_over_ms(); }

 private:
  LookMatcher matcher_;
  const StructureMap* structures_;
  StructureObserver observer_;
};

// The range is ours: what lies beyond it was not looked at.
class PclSiteLocalizer : public SiteLocalizer {
 public:
  explicit PclSiteLocalizer(const SiteLocalizerInputs& inputs) : inputs_(inputs) {}
  void go_to(const Eigen::Vector3d& p_map_m, std::uint64_t seed) override {
    ndt_.emplace(inputs_.map, p_map_m);
    seed_ = seed;
  }
  void take(const Scan& scan, const Look& look) override {
    const std::uint64_t seed = mix(seed_, std::bit_cast<std::uint64_t>(look.range_m));
    const std::vector<Eigen::Vector3d> points_m =
        sampler_.sample(scan, inputs_.sensor, {.range_m = look.range_m}, seed);
    ndt_->set_scan(points_m);
    point_count_ = points_m.size();
  }
  MatchResult match(const Pose& T_map_start) override {
    const PclMatch found = ndt_->match(T_map_start);
    MatchResult result;
    result.T_map_sensor = found.T_map_scan;
    result.iterations = found.iterations;
    result.work = static_cast<std::uint64_t>(found.iterations) * point_count_;
    return result;
  }
  [[nodiscard]] std::size_t point_count() const override { return point_count_; }

 private:
  SiteLocalizerInputs inputs_;
  AutowareSampler sampler_;
  std::optional<PclNdt> ndt_;
  std::uint64_t seed_ = 0;
  std::size_t point_count_ = 0;
};

LocalizerProfile own_profile(const LocalizerChoice& choice, double cell_m) {
  LocalizerProfile profile{std::string(localizer_name(choice.kind)),
                           kLocalizersVersion,
                           {{"cell_m", format_double(cell_m)},
                            {"coarse_cells", std::to_string(choice.coarse_cells)},
                            {"leaf_m", format_double(choice.leaf_m)}}};
  if (choice.takes_every_return) profile.parameters.emplace_back(kEveryReturn);
  return profile;
}

LocalizerProfile pcl_profile(double cell_m) {
  const AutowareFilters filters;
  return {"pcl-ndt",
          kLocalizersVersion,
          {{"box_m", format_double(filters.box_m)},
           {"epsilon_m", format_double(PclNdt::kEpsilon_m)},
           {"iterations", std::to_string(PclNdt::kIterations)},
           {"map_reach_m", format_double(PclNdt::kReach_m)},
           {"points", std::to_string(filters.most_points)},
           {"resolution_m", format_double(cell_m)},
           {"step_m", format_double(PclNdt::kStep_m)},
           {"voxel_m", format_double(filters.voxel_m)}}};
}

}  // namespace

void measure_scan(const MatchStarts& starts, const std::vector<Look>& looks,
                  const ReferencedScan& scan, SiteLocalizer& localizer, MeasuredRows& rows) {
  for (const Look& look : looks) {
    const double begin_ms = thread_cpu_ms();
    localizer.take(scan.scan, look);
    const double cut_ms = thread_cpu_ms() - begin_ms;
    rows.rows.push_back(measure_row(starts.acquiring, scan, cut_ms, localizer));
    measure_tracking(starts, scan, cut_ms, localizer, rows);
  }
}

Result<void> measure_site(const SiteMeasuring& measuring, SiteLocalizer& localizer,
                          std::size_t scan_index, SiteRows& rows) {
  SIGHTLINE_ASSIGN(const Scan scan, measuring.drive.store->read(scan_index));
  const Pose& T_map_given = measuring.trajectory.poses[scan_index].T_map_vehicle;
  localizer.go_to(T_map_given.translation(),
                  mix(measuring.seed, measuring.drive.scans[scan_index].recording_index));
  const ReferencedScan referenced{scan, reference_pose(measuring, localizer, scan, T_map_given),
                                  T_map_given};
  const auto& [ranges, samples] = measuring.looks;
  measure_scan(measuring.starts, ranges, referenced, localizer, rows.ranges);
  if (samples) measure_scan(measuring.starts, *samples, referenced, localizer, *rows.samples);
  return {};
}

std::unique_ptr<SiteLocalizer> make_site_localizer(const SiteLocalizerInputs& inputs) {
  if (inputs.choice.kind == LocalizerKind::kPclNdt) {
    return std::make_unique<PclSiteLocalizer>(inputs);
  }
  return std::make_unique<OwnSiteLocalizer>(inputs);
}

std::unique_ptr<SiteLocalizer> make_site_localizer(const LocalizerChoice& choice,
                                                   const SensorProfile& sensor,
                                                   const AreaLocalizer& area) {
  return make_site_localizer(
      {choice, sensor, area.for_pcl, area.own, area.of_samples, &area.structures});
}

LocalizerProfile profile_of(const LocalizerChoice& choice, double cell_m) {
  LocalizerProfile profile =
      choice.kind == LocalizerKind::kPclNdt ? pcl_profile(cell_m) : own_profile(choice, cell_m);
  if (choice.in_small_map) profile.parameters.emplace_back(kSmallMap);
  std::ranges::sort(profile.parameters);
  return profile;
}

}  // namespace sightline
