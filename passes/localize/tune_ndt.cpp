#include "passes/localize/tune_ndt.h"

#include <algorithm>
#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "formats/base/check.h"
#include "formats/base/parallel.h"
#include "formats/base/random.h"
#include "formats/base/stopwatch.h"
#include "formats/grid/point_grid.h"
#include "passes/localize/area_localizers.h"
#include "passes/localize/measure_site.h"
#include "passes/localize/pcl/pcl_ndt.h"
#include "passes/matching/match_starts.h"

namespace sightline {
namespace {

constexpr double kPoint = 0.01;     // of the share within the limit
constexpr double kTenthLess = 0.9;  // of the work
constexpr double kRounding = 1e-9;

constexpr double kBoxes_m[] = {15.0, 20.0, 30.0, 40.0, 60.0};
constexpr double kVoxels_m[] = {1.0, 2.0, 3.0};
constexpr std::size_t kCounts[] = {200, 500, 1000, 1500, 3000};

// What all scans share.
struct Tuning {
  const TuneNdtOptions& options;
  const Drive& drive;
  Trajectory in_map;
  const TiledNds& nds;
  std::vector<InitialOffset> starts;
  AreaLocalizers& areas;  // for the reference
  std::uint64_t seed = 0;
};

Result<void> check_inputs(const Drive& drive, const Trajectory& trajectory, const TiledNds& nds,
                          const Sites& sites) {
  SIGHTLINE_TRY(check_trajectory_of_drive(drive, trajectory));
  if (!(nds.head().frame == sites.frame)) {
    return Error{ErrorCode::kMismatchedInputs,
                 "the map and the sites are in different frames, expected one", "", ""};
  }
  if (nds.row_count() == 0) {
    return Error{ErrorCode::kEmptyMap, "the map has no valid cell to match with", "", ""};
  }
  return {};
}

std::vector<std::size_t> evenly(const std::vector<std::size_t>& all, std::size_t most) {
  if (all.size() <= most) return all;
  std::vector<std::size_t> taken;
  for (std::size_t i = 0; i < most; ++i)
    taken.push_back(all[(2 * i + 1) * all.size() / (2 * most)]);
  return taken;
}

// Scans that choose and scans that judge, in turn along the drive.
struct Shares {
  std::vector<std::size_t> choosing;
  std::vector<std::size_t> judging;
};

Result<Shares> shares_of(const Tuning& tuning, const Sites& sites) {
  std::vector<Eigen::Vector3d> places_m;
  for (const Site& site : sites.sites) places_m.push_back(site.T_map_vehicle.translation());
  const PointGrid grid(places_m);
  std::vector<std::size_t> near;
  for (std::size_t i = 0; i < tuning.drive.scans.size(); ++i) {
    const TrajectoryPose& pose = tuning.in_map.poses[i];
    if (!is_selected(tuning.drive.scans[i], tuning.options.scans) || !pose.is_laid) continue;
    const Eigen::Vector3d place_m = pose.T_map_vehicle.translation();
    if (grid.nearest_on_level(place_m, tuning.options.site_radius_m)) near.push_back(i);
  }
  if (near.size() < 2) {
    return Error{ErrorCode::kNoOverlap,
                 concat(near.size(), " scans of drive '", tuning.drive.name, "' are within ",
                        format_double(tuning.options.site_radius_m),
                        " m of the map's sites, expected at least 2"),
                 "", ""};
  }
  Shares shares;
  const std::vector<std::size_t> taken = evenly(near, tuning.options.most_scans);
  for (std::size_t i = 0; i < taken.size(); ++i) {
    (i % 2 == 0 ? shares.choosing : shares.judging).push_back(taken[i]);
  }
  return shares;
}

Result<Pose> reference_of(const Tuning& tuning, const Scan& scan, const Pose& T_map_given) {
  if (tuning.options.reference == ErrorReference::kKnownPose) return T_map_given;
  SIGHTLINE_ASSIGN(const std::shared_ptr<const AreaLocalizer> area,
                   tuning.areas.at(T_map_given.translation()));
  const SensorProfile& sensor = tuning.drive.sensor;
  const std::unique_ptr<SiteLocalizer> own = make_site_localizer({}, sensor, *area);
  own->take(scan, every_return(sensor.max_range_m));
  return own->match(T_map_given).T_map_sensor;
}

// PCL's NDT with the NDs around a scan.
Result<PclNdt> ndt_around(const Tuning& tuning, const Eigen::Vector3d& place_map_m) {
  const Eigen::Vector2d reach_m = Eigen::Vector2d::Constant(PclNdt::kReach_m);
  const Eigen::Vector2d place_m = place_map_m.head<2>();
  SIGHTLINE_ASSIGN(const NdtMap near, tuning.nds.over({place_m - reach_m, place_m + reach_m}));
  return PclNdt(near, place_map_m);
}

void add(const NdtFigures& one, NdtFigures& sum) {
  sum.within_share.resize(one.within_share.size());
  for (std::size_t i = 0; i < one.within_share.size(); ++i) {
    sum.within_share[i] += one.within_share[i];
  }
  sum.lost_share += one.lost_share;
  sum.error_m += one.error_m;
  sum.point_count += one.point_count;
  sum.work += one.work;
  sum.time_ms += one.time_ms;
}

void divide(double count, NdtFigures& sum) {
  for (double& share : sum.within_share) share /= count;
  for (double* figure :
       {&sum.lost_share, &sum.error_m, &sum.point_count, &sum.work, &sum.time_ms}) {
    *figure /= count;
  }
}

NdtFigures figures_of_match(const std::vector<double>& limits_m, double error_m) {
  NdtFigures figures;
  for (const double limit_m : limits_m) {
    figures.within_share.push_back(error_m <= limit_m ? 1.0 : 0.0);
  }
  figures.lost_share = error_m > kLostBeyond_m ? 1.0 : 0.0;
  figures.error_m = error_m;
  return figures;
}

// Of the points that were set last: the sum over all starts, each of which takes the time of the
// filters too.
NdtFigures sum_of_matches(const Tuning& tuning, const Pose& T_map_reference,
                          std::size_t point_count, double cut_ms, PclNdt& ndt) {
  NdtFigures sum;
  for (const InitialOffset& start : tuning.starts) {
    const double begin_ms = thread_cpu_ms();
    const PclMatch found = ndt.match(T_map_reference * start_pose(start));
    const double error_m = (found.T_map_scan.translation() - T_map_reference.translation()).norm();
    NdtFigures figures = figures_of_match(tuning.options.limits_m, error_m);
    figures.time_ms = cut_ms + thread_cpu_ms() - begin_ms;
    figures.point_count = static_cast<double>(point_count);
    figures.work = static_cast<double>(found.iterations) * figures.point_count;
    add(figures, sum);
  }
  return sum;
}

// Whether the filters leave the points that the ones before them left.
bool leave_the_same(const AutowareFilters& before, std::size_t point_count,
                    const AutowareFilters& filters) {
  return before.box_m == filters.box_m && before.voxel_m == filters.voxel_m &&
         before.most_points <= filters.most_points && point_count < before.most_points;
}

// For each of the filters the sum over the matches of a scan.
Result<std::vector<NdtFigures>> figures_at(const Tuning& tuning, std::size_t scan_index,
                                           std::span<const AutowareFilters> filters) {
  SIGHTLINE_ASSIGN(const Scan scan, tuning.drive.store->read(scan_index));
  const Pose& T_map_given = tuning.in_map.poses[scan_index].T_map_vehicle;
  SIGHTLINE_ASSIGN(const Pose T_map_reference, reference_of(tuning, scan, T_map_given));
  SIGHTLINE_ASSIGN(PclNdt ndt, ndt_around(tuning, T_map_given.translation()));
  const std::uint64_t seed = mix(tuning.seed, tuning.drive.scans[scan_index].recording_index);
  AutowareSampler sampler;
  std::vector<NdtFigures> all;
  std::size_t point_count = 0;
  for (std::size_t i = 0; i < filters.size(); ++i) {
    if (i > 0 && leave_the_same(filters[i - 1], point_count, filters[i])) {
      all.push_back(all.back());
      continue;
    }
    const double begin_ms = thread_cpu_ms();
    const std::vector<Eigen::Vector3d> points_m =
        sampler.sample(scan, tuning.drive.sensor, filters[i], seed);
    ndt.set_scan(points_m);
    const double cut_ms = thread_cpu_ms() - begin_ms;
    point_count = points_m.size();
    all.push_back(sum_of_matches(tuning, T_map_reference, point_count, cut_ms, ndt));
  }
  return all;
}

// Means over all matches.
Result<std::vector<TriedFilters>> try_on(const PassContext& ctx, const Tuning& tuning,
                                         const std::vector<std::size_t>& scans,
                                         std::span<const AutowareFilters> filters,
                                         const std::function<void(std::size_t)>& did) {
  SIGHTLINE_ASSIGN(
      const std::vector<std::vector<NdtFigures>> of_scans,
      parallel_results<std::vector<NdtFigures>>(
          scans.size(), ctx.threads, [&](std::size_t i) -> Result<std::vector<NdtFigures>> {
            Result<std::vector<NdtFigures>> figures = figures_at(tuning, scans[i], filters);
            did(filters.size());
            return figures;
          }));
  std::vector<TriedFilters> tried;
  for (std::size_t i = 0; i < filters.size(); ++i) {
    TriedFilters& one = tried.emplace_back(TriedFilters{filters[i], {}});
    for (const std::vector<NdtFigures>& of_scan : of_scans) add(of_scan[i], one.figures);
    divide(static_cast<double>(scans.size() * tuning.starts.size()), one.figures);
  }
  return tried;
}

const TriedFilters& defaults_of(const std::vector<TriedFilters>& tried) {
  const auto found = std::ranges::find(tried, AutowareFilters(), &TriedFilters::filters);
  SIGHTLINE_CHECK(found != tried.end());
  return *found;
}

// Defaults, cheapest and best.
std::vector<AutowareFilters> chosen_of(const std::vector<TriedFilters>& tried, std::size_t limit) {
  const TriedFilters& defaults = defaults_of(tried);
  const auto within = [&](const TriedFilters& one) { return one.figures.within_share[limit]; };
  const TriedFilters* cheapest = &defaults;
  const TriedFilters* best = &defaults;
  for (const TriedFilters& one : tried) {
    const double work = one.figures.work;
    const bool holds_as_much = within(one) + kRounding >= within(defaults) &&
                               one.figures.lost_share <= defaults.figures.lost_share + kRounding;
    if (holds_as_much && work < cheapest->figures.work) cheapest = &one;
    const double more = within(one) - within(*best);
    if (more > kRounding || (more > -kRounding && work < best->figures.work)) best = &one;
  }
  return {defaults.filters, cheapest->filters, best->filters};
}

}  // namespace

bool NdtTuning::is_cheaper() const {
  const NdtFigures& now = cheapest.figures;
  const NdtFigures& before = defaults.figures;
  return now.within_share[limit] + kPoint + kRounding >= before.within_share[limit] &&
         now.lost_share <= before.lost_share + kRounding && now.work <= kTenthLess * before.work;
}

bool NdtTuning::is_better() const {
  return best.figures.within_share[limit] >
         defaults.figures.within_share[limit] + kPoint + kRounding;
}

std::vector<AutowareFilters> filters_to_try() {
  std::vector<AutowareFilters> filters;
  for (const double box_m : kBoxes_m) {
    for (const double voxel_m : kVoxels_m) {
      for (const std::size_t count : kCounts) filters.push_back({box_m, voxel_m, count});
    }
  }
  return filters;
}

Result<NdtTuning> tune_ndt(const PassContext& ctx, const TuneNdtOptions& options,
                           const Drive& drive, const Trajectory& trajectory, const TiledNds& nds,
                           const Sites& sites) {
  SIGHTLINE_CHECK(options.most_scans >= 2 && options.limit < options.limits_m.size());
  SIGHTLINE_TRY(check_inputs(drive, trajectory, nds, sites));
  SIGHTLINE_TRY(validate(options.tracking));
  AreaLocalizers areas(nds, {.longest_m = drive.sensor.max_range_m, .threads = ctx.threads});
  const Tuning tuning{options,
                      drive,
                      rebase(trajectory, nds.head().frame),
                      nds,
                      tracking_offsets(options.tracking),
                      areas,
                      ctx.seed};
  SIGHTLINE_ASSIGN(const Shares shares, shares_of(tuning, sites));
  std::atomic<std::size_t> done = 0;
  constexpr std::size_t kJudged = 3;
  const std::size_t total =
      shares.choosing.size() * options.filters.size() + shares.judging.size() * kJudged;
  const auto did = [&](std::size_t count) { ctx.progress(done += count, total); };
  NdtTuning found{drive.name,
                  nds.head().cell_m,
                  options.reference,
                  options.limits_m,
                  options.limit,
                  tuning.starts.size(),
                  shares.choosing.size(),
                  shares.judging.size(),
                  {},
                  {},
                  {},
                  {}};
  SIGHTLINE_ASSIGN(found.tried, try_on(ctx, tuning, shares.choosing, options.filters, did));
  SIGHTLINE_ASSIGN(const std::vector<TriedFilters> judged,
                   try_on(ctx, tuning, shares.judging, chosen_of(found.tried, options.limit), did));
  found.defaults = judged[0];
  found.cheapest = judged[1];
  found.best = judged[2];
  return found;
}

}  // namespace sightline
