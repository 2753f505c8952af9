#include "passes/localize/measure_error.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <span>

#include "formats/base/parallel.h"
#include "formats/base/portable_math.h"
#include "formats/base/random.h"
#include "formats/base/statistics.h"
#include "formats/base/stopwatch.h"
#include "formats/drive/trajectory_of_drive.h"
#include "formats/grid/point_grid.h"
#include "passes/localize/site_localizer.h"
#include "passes/pass/scan_selection.h"

namespace sightline {
namespace {

// What all sites share.
struct Setup {
  const MeasureErrorOptions& options;
  const Drive& drive;
  const Trajectory& trajectory;  // in the map's frame
  const SiteLocalizerInputs& localizer;
  const std::vector<InitialOffset>& offsets;
  std::uint64_t seed = 0;
};

void add_run(const MatchResult& result, const Pose& T_map_reference, double count, ErrorRow& row) {
  const Pose T_reference_found = T_map_reference.inverse(Eigen::Isometry) * result.T_map_sensor;
  const Eigen::Vector3d off_m = T_reference_found.translation();
  const double yaw_rad = portable_atan2(T_reference_found(1, 0), T_reference_found(0, 0));
  const auto work = static_cast<double>(result.work);
  row.mean_m += off_m.norm() / count;
  row.longitudinal_m += std::abs(off_m.x()) / count;
  row.lateral_m += std::abs(off_m.y()) / count;
  row.yaw_rad += std::abs(yaw_rad) / count;
  row.lost_share += (off_m.norm() > kLostBeyond_m ? 1.0 : 0.0) / count;
  row.mean_iterations += result.iterations / count;
  row.mean_work += work / count;
  row.max_work = std::max(row.max_work, work);
}

// All offsets at one range. `preparation_ms` is what cropping and subsampling took: the runs share
// it here, but a vehicle pays it for each scan, so it counts in full for each run.
ErrorRow measure_row(const Setup& setup, SiteLocalizer& localizer, const Pose& T_map_reference,
                     double preparation_ms) {
  ErrorRow row;
  const auto count = static_cast<double>(setup.offsets.size());
  std::vector<double> errors_m;
  for (const InitialOffset& offset : setup.offsets) {
    const double begin_ms = thread_cpu_ms();
    const MatchResult result = localizer.match(T_map_reference * start_pose(offset));
    const double time_ms = preparation_ms + thread_cpu_ms() - begin_ms;
    add_run(result, T_map_reference, count, row);
    row.mean_time_ms += time_ms / count;
    row.max_time_ms = std::max(row.max_time_ms, time_ms);
    errors_m.push_back((result.T_map_sensor.translation() - T_map_reference.translation()).norm());
  }
  // A sum of shares of n may end an ulp above 1.
  row.lost_share = std::min(row.lost_share, 1.0);
  std::sort(errors_m.begin(), errors_m.end());
  row.median_m = quantile_of_sorted(errors_m, 0.5);
  row.p90_m = quantile_of_sorted(errors_m, 0.9);
  row.max_m = errors_m.back();
  return row;
}

Pose reference_pose(const Setup& setup, SiteLocalizer& localizer, const Scan& scan,
                    const Pose& T_map_given) {
  if (setup.options.reference == ErrorReference::kKnownPose) return T_map_given;
  localizer.take(scan, setup.drive.sensor.max_range_m);
  return localizer.match(T_map_given).T_map_sensor;
}

Result<std::vector<ErrorRow>> measure_site(const Setup& setup, SiteLocalizer& localizer,
                                           std::size_t scan_index) {
  SIGHTLINE_ASSIGN(const Scan scan, setup.drive.store->read(scan_index));
  const Pose& T_map_given = setup.trajectory.poses[scan_index].T_map_vehicle;
  localizer.go_to(T_map_given.translation(),
                  mix(setup.seed, setup.drive.scans[scan_index].recording_index));
  const Pose T_map_reference = reference_pose(setup, localizer, scan, T_map_given);
  std::vector<ErrorRow> rows;
  for (const double range_m : setup.options.ranges_m) {
    const double begin_ms = thread_cpu_ms();
    const std::size_t point_count = localizer.take(scan, range_m);
    const double preparation_ms = thread_cpu_ms() - begin_ms;
    rows.push_back(measure_row(setup, localizer, T_map_reference, preparation_ms));
    rows.back().point_count = static_cast<std::uint32_t>(point_count);
  }
  return rows;
}

Result<void> check_inputs(const Drive& drive, const Trajectory& trajectory, const NdtMap& map,
                          const Sites& sites) {
  SIGHTLINE_TRY(check_trajectory_of_drive(drive, trajectory));
  if (!(map.frame == sites.frame)) {
    return Error{ErrorCode::kMismatchedInputs,
                 "the map and the sites are in different frames, expected one", "",
                 "pass measure-error"};
  }
  if (map.nds.empty()) {
    return Error{ErrorCode::kEmptyMap, "the map has no valid cell to match with", "",
                 "pass measure-error"};
  }
  return {};
}

// Consecutive sites that are kept together when a run is interrupted: a second or two of work.
constexpr std::size_t kSitesInPart = 16;

// Rows of sites [first, last), each one's ranges in order.
Result<std::vector<ErrorRow>> measure_part(const Setup& setup,
                                           std::span<const std::optional<std::size_t>> scans,
                                           const std::function<void()>& site_done) {
  std::vector<ErrorRow> rows;
  const std::unique_ptr<SiteLocalizer> localizer = make_site_localizer(setup.localizer);
  for (const std::optional<std::size_t>& scan : scans) {
    SIGHTLINE_ASSIGN(std::vector<ErrorRow> measured,
                     scan ? measure_site(setup, *localizer, *scan)
                          : std::vector<ErrorRow>(setup.options.ranges_m.size()));
    rows.insert(rows.end(), measured.begin(), measured.end());
    site_done();
  }
  return rows;
}

// A part as an artifact of its own, with its sites alone.
MeasuredError part_of(const MeasuredError& all, std::size_t first_site, std::size_t last_site) {
  MeasuredError part = all;
  part.rows.clear();
  part.scan_of_site.assign(all.scan_of_site.begin() + static_cast<std::ptrdiff_t>(first_site),
                           all.scan_of_site.begin() + static_cast<std::ptrdiff_t>(last_site));
  return part;
}

// The part's rows as an interrupted run left them; empty where it did not or they are damaged.
std::vector<ErrorRow> saved_rows(const PassContext& ctx, std::size_t number,
                                 const MeasuredError& expected) {
  const std::optional<std::vector<std::byte>> bytes = ctx.load_part(number);
  if (!bytes) return {};
  Result<MeasuredError> part = from_bytes<MeasuredError>(*bytes);
  if (!part || part->scan_of_site != expected.scan_of_site) return {};
  return std::move(part->rows);
}

// Fills rows of every site that has a scan, part by part; the first failure in the order of sites
// is returned.
Result<void> measure_sites(PassContext& ctx, const Setup& setup,
                           const std::vector<std::optional<std::size_t>>& scans,
                           MeasuredError& measured) {
  const std::size_t part_count = (scans.size() + kSitesInPart - 1) / kSitesInPart;
  std::vector<std::optional<Error>> failures(part_count);
  std::atomic<std::size_t> done = 0;
  const auto site_done = [&] { ctx.progress(++done, scans.size()); };
  parallel_for(part_count, ctx.threads, [&](std::size_t number) {
    const std::size_t first = number * kSitesInPart;
    const std::size_t last = std::min(first + kSitesInPart, scans.size());
    MeasuredError part = part_of(measured, first, last);
    part.rows = saved_rows(ctx, number, part);
    const bool is_saved = !part.rows.empty();
    if (is_saved) {
      for (std::size_t site = first; site < last; ++site) site_done();
    } else {
      Result<std::vector<ErrorRow>> rows =
          measure_part(setup, std::span(scans).subspan(first, last - first), site_done);
      if (!rows) {
        failures[number] = rows.error();
        return;
      }
      part.rows = std::move(*rows);
      ctx.save_part(number, to_bytes(part));
    }
    std::copy(part.rows.begin(), part.rows.end(),
              measured.rows.begin() + static_cast<std::ptrdiff_t>(part.shape().size(first)));
  });
  for (const std::optional<Error>& failure : failures) {
    if (failure) return *failure;
  }
  return {};
}

// Position of each site's nearest selected scan within the radius, the first on a tie.
std::vector<std::optional<std::size_t>> nearest_scans(const Setup& setup, const Sites& sites) {
  const ScanSelection selection = setup.options.scans;
  std::vector<std::size_t> selected;
  std::vector<Eigen::Vector3d> places_m;
  for (std::size_t i = 0; i < setup.drive.scans.size(); ++i) {
    if (!is_selected(setup.drive.scans[i], selection)) continue;
    selected.push_back(i);
    places_m.push_back(setup.trajectory.poses[i].T_map_vehicle.translation());
  }
  const PointGrid grid(places_m);
  std::vector<std::optional<std::size_t>> scans;
  for (const Site& site : sites.sites) {
    const std::optional<NearPoint> nearest =
        grid.nearest(site.T_map_vehicle.translation(), setup.options.site_radius_m);
    scans.push_back(nearest ? std::optional(selected[nearest->index]) : std::nullopt);
  }
  return scans;
}

MatchingCard matching_card(const MeasureErrorOptions& options, const NdtMap& map) {
  MatchingCard card;
  card.scans = options.scans;
  card.localizer = profile_of({options.localizer, options.coarse_cells, options.leaf_m}, map);
  card.site_step = static_cast<std::uint32_t>(site_step_of(options));
  const bool is_own = options.localizer != LocalizerKind::kPclNdt;
  card.coarse_cells = is_own ? static_cast<std::uint32_t>(options.coarse_cells) : 1;
  card.leaf_m = is_own ? options.leaf_m : 0.0;
  return card;
}

// Where each site has its scan. Error: no-overlap.
Result<std::vector<std::optional<std::size_t>>> scans_of_sites(PassContext& ctx, const Setup& setup,
                                                               const Sites& sites) {
  const std::vector<std::optional<std::size_t>> scans = nearest_scans(setup, sites);
  const auto without =
      static_cast<std::size_t>(std::count(scans.begin(), scans.end(), std::nullopt));
  const std::string radius = format_double(setup.options.site_radius_m);
  if (without == scans.size()) {
    return Error{ErrorCode::kNoOverlap,
                 "none of " + std::to_string(scans.size()) + " sites has a scan of drive '" +
                     setup.drive.name + "' within " + radius + " m",
                 "", "pass measure-error"};
  }
  if (without > 0) {
    ctx.warn(std::to_string(without) + " of " + std::to_string(scans.size()) +
             " sites have no scan of drive '" + setup.drive.name + "' within " + radius +
             " m and were not measured");
  }
  return scans;
}

// Leaves every step-th.
void thin_sites(std::size_t step, std::vector<std::optional<std::size_t>>& scans) {
  for (std::size_t site = 0; site < scans.size(); ++site) {
    if (site % step != 0) scans[site].reset();
  }
}

}  // namespace

ErrorReference reference_of(const MeasureErrorOptions& options, const Trajectory& trajectory) {
  const bool is_known = options.is_mapping_drive || trajectory.source != PoseSource::kEstimated;
  return is_known ? options.reference : ErrorReference::kFullRangeMatch;
}

Result<MeasuredError> measure_error(PassContext& ctx, const MeasureErrorOptions& wanted,
                                    const Drive& localization_drive, const Trajectory& trajectory,
                                    const NdtMap& map, const Sites& sites) {
  SIGHTLINE_TRY(check_inputs(localization_drive, trajectory, map, sites));
  MeasureErrorOptions options = wanted;
  options.reference = reference_of(wanted, trajectory);
  if (options.reference != wanted.reference) {
    ctx.warn("drive '" + localization_drive.name +
             "' has no known poses, its trajectory was found by matching: errors are measured "
             "against matches to this very map at the sensor's full range");
  }
  const Trajectory in_map = rebase(trajectory, map.frame);
  const bool is_own = options.localizer != LocalizerKind::kPclNdt;
  const Localizer own =
      is_own ? make_localizer(map, localizer_options(options.localizer, options.coarse_cells))
             : Localizer{};
  const SiteLocalizerInputs localizer{{options.localizer, options.coarse_cells, options.leaf_m},
                                      localization_drive.sensor,
                                      map,
                                      own};
  const std::vector<InitialOffset> offsets = initial_offsets(starts_of(options));
  const Setup setup{options, localization_drive, in_map, localizer, offsets, ctx.seed};
  SIGHTLINE_ASSIGN(std::vector<std::optional<std::size_t>> scans,
                   scans_of_sites(ctx, setup, sites));
  thin_sites(static_cast<std::size_t>(site_step_of(options)), scans);
  MeasuredError measured;
  measured.drive = localization_drive.name;
  measured.matching = matching_card(options, map);
  measured.reference = options.reference;
  measured.ranges_m = options.ranges_m;
  measured.offsets = offsets;
  for (const std::optional<std::size_t>& scan : scans) {
    measured.scan_of_site.push_back(
        scan ? static_cast<std::int64_t>(localization_drive.scans[*scan].recording_index) : -1);
  }
  measured.rows.resize(measured.shape().size(scans.size()));
  SIGHTLINE_TRY(measure_sites(ctx, setup, scans, measured));
  return measured;
}

}  // namespace sightline
