#include "passes/localize/measure_error.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <span>

#include "formats/base/parallel.h"
#include "formats/drive/trajectory_of_drive.h"
#include "formats/grid/point_grid.h"
#include "passes/localize/measure_site.h"
#include "passes/localize/site_localizer.h"
#include "passes/pass/scan_selection.h"

namespace sightline {
namespace {

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

// Of consecutive sites.
Result<SiteRows> measure_part(const SiteMeasuring& measuring,
                              std::span<const std::optional<std::size_t>> scans,
                              const std::function<void()>& site_done) {
  SiteRows rows;
  const std::unique_ptr<SiteLocalizer> localizer = make_site_localizer(measuring.localizer);
  for (const std::optional<std::size_t>& scan : scans) {
    if (scan) {
      SIGHTLINE_TRY(measure_site(measuring, *localizer, *scan, rows));
    } else {
      rows.rows.resize(rows.rows.size() + measuring.looks.size());
      rows.samples.resize(rows.samples.size() + measuring.samples.size());
    }
    site_done();
  }
  return rows;
}

// Some sites of it as an artifact of its own, without rows.
MeasuredError part_of(const MeasuredError& all, std::size_t first_site, std::size_t last_site) {
  MeasuredError part = all;
  part.rows.clear();
  part.scan_of_site.assign(all.scan_of_site.begin() + static_cast<std::ptrdiff_t>(first_site),
                           all.scan_of_site.begin() + static_cast<std::ptrdiff_t>(last_site));
  for (MeasuredError& samples : part.of_samples) {
    samples.rows.clear();
    samples.scan_of_site = part.scan_of_site;
  }
  return part;
}

// Whether the rows are those that an interrupted run left; false where it did not or they are
// damaged.
bool take_saved(const PassContext& ctx, std::size_t number, MeasuredError& part) {
  const std::optional<std::vector<std::byte>> bytes = ctx.load_part(number);
  if (!bytes) return false;
  Result<MeasuredError> saved = from_bytes<MeasuredError>(*bytes);
  if (!saved || saved->scan_of_site != part.scan_of_site ||
      saved->of_samples.size() != part.of_samples.size()) {
    return false;
  }
  part = std::move(*saved);
  return true;
}

void put_part(const MeasuredError& part, std::size_t first_site, MeasuredError& measured) {
  std::copy(part.rows.begin(), part.rows.end(),
            measured.rows.begin() + static_cast<std::ptrdiff_t>(part.shape().size(first_site)));
  for (std::size_t i = 0; i < part.of_samples.size(); ++i) {
    put_part(part.of_samples[i], first_site, measured.of_samples[i]);
  }
}

// Fills rows of every site that has a scan, part by part; the first failure in the order of sites
// is returned.
Result<void> measure_sites(PassContext& ctx, const SiteMeasuring& measuring,
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
    if (take_saved(ctx, number, part)) {
      for (std::size_t site = first; site < last; ++site) site_done();
    } else {
      Result<SiteRows> rows =
          measure_part(measuring, std::span(scans).subspan(first, last - first), site_done);
      if (!rows) {
        failures[number] = rows.error();
        return;
      }
      part.rows = std::move(rows->rows);
      for (MeasuredError& samples : part.of_samples) samples.rows = std::move(rows->samples);
      ctx.save_part(number, to_bytes(part));
    }
    put_part(part, first, measured);
  });
  for (const std::optional<Error>& failure : failures) {
    if (failure) return *failure;
  }
  return {};
}

// Position of each site's nearest selected scan within the radius, the first on a tie.
std::vector<std::optional<std::size_t>> nearest_scans(const MeasureErrorOptions& options,
                                                      const SiteMeasuring& measuring,
                                                      const Sites& sites) {
  const ScanSelection selection = options.scans;
  std::vector<std::size_t> selected;
  std::vector<Eigen::Vector3d> places_m;
  for (std::size_t i = 0; i < measuring.drive.scans.size(); ++i) {
    if (!is_selected(measuring.drive.scans[i], selection)) continue;
    selected.push_back(i);
    places_m.push_back(measuring.trajectory.poses[i].T_map_vehicle.translation());
  }
  const PointGrid grid(places_m);
  std::vector<std::optional<std::size_t>> scans;
  for (const Site& site : sites.sites) {
    const std::optional<NearPoint> nearest =
        grid.nearest(site.T_map_vehicle.translation(), options.site_radius_m);
    scans.push_back(nearest ? std::optional(selected[nearest->index]) : std::nullopt);
  }
  return scans;
}

// Where each site has its scan. Error: no-overlap.
Result<std::vector<std::optional<std::size_t>>> scans_of_sites(PassContext& ctx,
                                                               const MeasureErrorOptions& options,
                                                               const SiteMeasuring& measuring,
                                                               const Sites& sites) {
  const std::vector<std::optional<std::size_t>> scans = nearest_scans(options, measuring, sites);
  const auto without =
      static_cast<std::size_t>(std::count(scans.begin(), scans.end(), std::nullopt));
  const std::string radius = format_double(options.site_radius_m);
  if (without == scans.size()) {
    return Error{ErrorCode::kNoOverlap,
                 "none of " + std::to_string(scans.size()) + " sites has a scan of drive '" +
                     measuring.drive.name + "' within " + radius + " m",
                 "", "pass measure-error"};
  }
  if (without > 0) {
    ctx.warn(std::to_string(without) + " of " + std::to_string(scans.size()) +
             " sites have no scan of drive '" + measuring.drive.name + "' within " + radius +
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

// Rows of zeros at every look.
MeasuredError empty_result(const SiteMeasuring& measuring, const MatchingCard& matching,
                           const std::vector<std::optional<std::size_t>>& scans) {
  MeasuredError measured;
  measured.drive = measuring.drive.name;
  measured.matching = matching;
  measured.reference = measuring.reference;
  measured.looks = measuring.looks;
  measured.offsets = measuring.offsets;
  for (const std::optional<std::size_t>& scan : scans) {
    measured.scan_of_site.push_back(
        scan ? static_cast<std::int64_t>(measuring.drive.scans[*scan].recording_index) : -1);
  }
  if (!measuring.samples.empty()) {
    MeasuredError samples = measured;
    samples.looks = measuring.samples;
    samples.rows.resize(samples.shape().size(scans.size()));
    measured.of_samples.push_back(std::move(samples));
  }
  measured.rows.resize(measured.shape().size(scans.size()));
  return measured;
}

}  // namespace

MatchingCard matching_card(const MeasureErrorOptions& options, const NdtMap& map) {
  MatchingCard card;
  card.scans = options.scans;
  card.localizer = profile_of(
      {options.localizer, options.coarse_cells, options.leaf_m, options.every_return}, map);
  card.site_step = static_cast<std::uint32_t>(site_step_of(options));
  const bool is_own = options.localizer != LocalizerKind::kPclNdt;
  card.coarse_cells = is_own ? static_cast<std::uint32_t>(options.coarse_cells) : 1;
  card.leaf_m = is_own ? options.leaf_m : 0.0;
  return card;
}

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
  const std::vector<Look> samples = is_own ? options.looks : std::vector<Look>{};
  const Localizer own =
      is_own ? make_localizer(map, localizer_options(options.localizer, options.coarse_cells))
             : Localizer{};
  const Localizer of_samples = samples.empty()
                                   ? Localizer{}
                                   : make_localizer(map, options_for_samples(options.coarse_cells));
  const SiteLocalizerInputs localizer{
      {options.localizer, options.coarse_cells, options.leaf_m, options.every_return},
      localization_drive.sensor,
      map,
      own,
      of_samples};
  const std::vector<InitialOffset> offsets = initial_offsets(starts_of(options));
  const SiteMeasuring measuring{options.reference,
                                localization_drive,
                                in_map,
                                localizer,
                                offsets,
                                every_return_at(options.ranges_m),
                                samples,
                                ctx.seed};
  SIGHTLINE_ASSIGN(std::vector<std::optional<std::size_t>> scans,
                   scans_of_sites(ctx, options, measuring, sites));
  thin_sites(static_cast<std::size_t>(site_step_of(options)), scans);
  MeasuredError measured = empty_result(measuring, matching_card(options, map), scans);
  SIGHTLINE_TRY(measure_sites(ctx, measuring, scans, measured));
  return measured;
}

}  // namespace sightline
