#include "passes/localize/measure_error.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "formats/drive/trajectory.h"
#include "formats/grid/point_grid.h"
#include "passes/localize/area_localizers.h"
#include "passes/localize/measure_site.h"
#include "passes/localize/measured_parts.h"
#include "passes/localize/pcl/pcl_ndt.h"
#include "passes/pass/scan_selection.h"
#include "passes/pass/tile_digests.h"

namespace sightline {
namespace {

Result<void> check_inputs(const Drive& drive, const Trajectory& trajectory, const TiledNds& nds,
                          const Sites& sites) {
  SIGHTLINE_TRY(check_trajectory_of_drive(drive, trajectory));
  if (!(nds.head().frame == sites.frame)) {
    return Error{ErrorCode::kMismatchedInputs,
                 "the map and the sites are in different frames, expected one", "",
                 "pass measure-error"};
  }
  if (nds.row_count() == 0) {
    return Error{ErrorCode::kEmptyMap, "the map has no valid cell to match with", "",
                 "pass measure-error"};
  }
  return {};
}

constexpr std::size_t kSitesInPart = 16;

// Makes localizers of places.
class Localizing {
 public:
  Localizing(const MeasureErrorOptions& options, const SensorProfile& sensor, const TiledNds& nds,
             const AreaLocalizers::Options& areas)
      : choice_{options.localizer, options.coarse_cells, options.leaf_m, options.every_return},
        sensor_(sensor),
        nds_(nds),
        areas_(nds, areas) {}

  // Of the area of a place. Error: cannot-read.
  [[nodiscard]] Result<std::shared_ptr<const AreaLocalizer>> area_at(
      const Eigen::Vector3d& p_map_m) {
    return areas_.at(p_map_m);
  }

  [[nodiscard]] LocalizerKind kind() const { return choice_.kind; }
  [[nodiscard]] const TiledNds& nds() const { return nds_; }

  // Refers to the area.
  [[nodiscard]] std::unique_ptr<SiteLocalizer> localizer_in(const AreaLocalizer& area) const {
    return make_site_localizer(choice_, sensor_, area);
  }

 private:
  LocalizerChoice choice_;
  const SensorProfile& sensor_;
  const TiledNds& nds_;
  AreaLocalizers areas_;
};

// Of a site without a scan.
void append_zeros(const SiteMeasuring& measuring, std::size_t look_count, MeasuredRows& rows) {
  rows.rows.resize(rows.rows.size() + look_count);
  rows.tracking_ends.resize(rows.rows.size() * measuring.starts.tracking.size());
}

// Of consecutive sites.
Result<SiteRows> measure_part(const SiteMeasuring& measuring, Localizing& localizing,
                              std::span<const std::optional<std::size_t>> scans) {
  const auto& [ranges, samples] = measuring.looks;
  SiteRows rows;
  if (samples) rows.samples.emplace();
  std::shared_ptr<const AreaLocalizer> area;
  std::unique_ptr<SiteLocalizer> localizer;
  for (const std::optional<std::size_t>& scan : scans) {
    if (scan) {
      const Pose& T_map_vehicle = measuring.trajectory.poses[*scan].T_map_vehicle;
      SIGHTLINE_ASSIGN(const std::shared_ptr<const AreaLocalizer> here,
                       localizing.area_at(T_map_vehicle.translation()));
      if (here != area) {
        localizer = localizing.localizer_in(*here);
        area = here;
      }
      SIGHTLINE_TRY(measure_site(measuring, *localizer, *scan, rows));
    } else {
      append_zeros(measuring, ranges.size(), rows.ranges);
      if (samples) append_zeros(measuring, samples->size(), *rows.samples);
    }
  }
  return rows;
}

// Consecutive sites, a second or two of work.
std::vector<std::vector<std::size_t>> parts_of(std::size_t site_count) {
  std::vector<std::vector<std::size_t>> parts;
  for (std::size_t site = 0; site < site_count; ++site) {
    if (site % kSitesInPart == 0) parts.emplace_back();
    parts.back().push_back(site);
  }
  return parts;
}

// From the sensor to the farthest point that is ever matched.
double longest_match_m(const SiteMeasuring& measuring) {
  const double sensor_m = measuring.drive.sensor.max_range_m;
  if (measuring.reference == ErrorReference::kFullRangeMatch) return sensor_m;
  double longest_m = 0.0;
  visit_families(measuring.looks, [&](const std::vector<Look>& looks) {
    for (const Look& look : looks) longest_m = std::max(longest_m, look.range_m);
  });
  return std::min(longest_m, sensor_m);
}

// From the vehicle's place to the farthest ND that the localizer meets, but for its strays.
double reach_of_localizer_m(LocalizerKind kind, const SiteMeasuring& measuring) {
  return kind == LocalizerKind::kPclNdt ? PclNdt::kReach_m : longest_match_m(measuring);
}

void put(MeasuredRows rows, MeasuredError& measured) {
  measured.rows = std::move(rows.rows);
  measured.tracking_ends = std::move(rows.tracking_ends);
}

// Rows of every site that has a scan; the first failure in the order of sites is returned.
Result<ByFamily<StoredTable<MeasuredError>>> measure_sites(
    const PassContext& ctx, const SiteMeasuring& measuring, Localizing& localizing,
    const std::vector<std::optional<std::size_t>>& scans, const ByFamily<MeasuredError>& measured) {
  const auto fill = [&](std::size_t part, ByFamily<MeasuredError>& empty) -> Result<void> {
    const std::size_t site_count = empty.ranges.scan_of_site.size();
    SIGHTLINE_ASSIGN(SiteRows rows,
                     measure_part(measuring, localizing,
                                  std::span(scans).subspan(part * kSitesInPart, site_count)));
    put(std::move(rows.ranges), empty.ranges);
    if (empty.samples) put(std::move(*rows.samples), *empty.samples);
    return {};
  };
  const std::vector<std::vector<std::size_t>> parts = parts_of(scans.size());
  SIGHTLINE_ASSIGN(TileDigests nds, digests_of(localizing.nds()));
  const MatchContents contents(measuring.drive, measuring.trajectory, std::move(nds),
                               longest_match_m(measuring));
  const auto content = [&](std::size_t part) -> std::optional<Digest> {
    // How far PCL's matcher goes is not known.
    if (localizing.kind() == LocalizerKind::kPclNdt) return std::nullopt;
    return contents.of(std::span(scans).subspan(part * kSitesInPart, parts[part].size()));
  };
  // Neighbours share the localizers of an area, which one of them makes; no two read the same scan.
  return fill_in_parts(ctx, {parts, fill, content, PartOrder::kApart}, ctx.threads, measured);
}

// Position of each site's nearest selected scan on its level within the radius, the first on a tie.
std::vector<std::optional<std::size_t>> nearest_scans(const MeasureErrorOptions& options,
                                                      const SiteMeasuring& measuring,
                                                      const Sites& sites) {
  const ScanSelection selection = options.scans;
  std::vector<std::size_t> selected;
  std::vector<Eigen::Vector3d> places_m;
  for (std::size_t i = 0; i < measuring.drive.scans.size(); ++i) {
    const TrajectoryPose& pose = measuring.trajectory.poses[i];
    if (!is_selected(measuring.drive.scans[i], selection) || !pose.is_laid) continue;
    selected.push_back(i);
    places_m.push_back(pose.T_map_vehicle.translation());
  }
  const PointGrid grid(places_m);
  std::vector<std::optional<std::size_t>> scans;
  for (const Site& site : sites.sites) {
    const std::optional<NearPoint> nearest =
        grid.nearest_on_level(site.T_map_vehicle.translation(), options.site_radius_m);
    scans.push_back(nearest ? std::optional(selected[nearest->index]) : std::nullopt);
  }
  return scans;
}

// Where each site has its scan. Error: no-overlap, unless the drive may be elsewhere.
Result<std::vector<std::optional<std::size_t>>> scans_of_sites(PassContext& ctx,
                                                               const MeasureErrorOptions& options,
                                                               const SiteMeasuring& measuring,
                                                               const Sites& sites) {
  const std::vector<std::optional<std::size_t>> scans = nearest_scans(options, measuring, sites);
  const auto without =
      static_cast<std::size_t>(std::count(scans.begin(), scans.end(), std::nullopt));
  const std::string radius = format_double(options.site_radius_m);
  if (without == scans.size() && !options.may_be_elsewhere) {
    return Error{ErrorCode::kNoOverlap,
                 concat("none of ", scans.size(), " sites has a scan of drive '",
                        measuring.drive.name, "' within ", radius, " m"),
                 "", "pass measure-error"};
  }
  if (without > 0) {
    ctx.warn(concat(without, " of ", scans.size(), " sites have no scan of drive '",
                    measuring.drive.name, "' within ", radius, " m and were not measured"));
  }
  return scans;
}

// Leaves every step-th.
void thin_sites(std::size_t step, std::vector<std::optional<std::size_t>>& scans) {
  for (std::size_t site = 0; site < scans.size(); ++site) {
    if (site % step != 0) scans[site].reset();
  }
}

// Without rows.
ByFamily<MeasuredError> empty_result(const SiteMeasuring& measuring, const MatchingCard& matching,
                                     const std::vector<std::optional<std::size_t>>& scans) {
  MeasuredError measured;
  measured.drive = measuring.drive.name;
  measured.matching = matching;
  measured.reference = measuring.reference;
  measured.looks = measuring.looks.ranges;
  measured.offsets = measuring.starts.acquiring;
  measured.tracking_offsets = measuring.starts.tracking;
  for (const std::optional<std::size_t>& scan : scans) {
    measured.scan_of_site.push_back(
        scan ? static_cast<std::int64_t>(measuring.drive.scans[*scan].recording_index) : -1);
  }
  ByFamily<MeasuredError> both(measured);
  if (measuring.looks.samples) {
    both.samples = std::move(measured);
    both.samples->looks = *measuring.looks.samples;
  }
  return both;
}

}  // namespace

MatchingCard matching_card(const MeasureErrorOptions& options, double cell_m) {
  MatchingCard card;
  card.scans = options.scans;
  card.localizer = profile_of({options.localizer, options.coarse_cells, options.leaf_m,
                               options.every_return, options.in_small_map},
                              cell_m);
  card.site_step = static_cast<std::uint32_t>(site_step_of(options));
  const bool is_own = options.localizer != LocalizerKind::kPclNdt;
  card.coarse_cells = is_own ? static_cast<std::uint32_t>(options.coarse_cells) : 1;
  card.leaf_m = is_own ? options.leaf_m : 0.0;
  return card;
}

ErrorReference reference_of(const MeasureErrorOptions& options, const Trajectory& trajectory) {
  const bool is_known = trajectory.source != PoseSource::kEstimated;
  return is_known ? options.reference : ErrorReference::kFullRangeMatch;
}

Result<ByFamily<StoredTable<MeasuredError>>> measure_error(
    PassContext& ctx, const MeasureErrorOptions& wanted, const Drive& localization_drive,
    const Trajectory& trajectory, const TiledNds& nds, const Sites& sites) {
  SIGHTLINE_TRY(check_inputs(localization_drive, trajectory, nds, sites));
  SIGHTLINE_TRY(validate(wanted.tracking));
  MeasureErrorOptions options = wanted;
  options.reference = reference_of(wanted, trajectory);
  if (options.reference != wanted.reference) {
    ctx.warn(concat("drive '", localization_drive.name,
                    "' has no given poses: errors are measured against matches to this map at the "
                    "sensor's full range"));
  }
  const Trajectory in_map = rebase(trajectory, nds.head().frame);
  const bool is_own = options.localizer != LocalizerKind::kPclNdt;
  ByFamily<std::vector<Look>> looks(every_return_at(options.ranges_m));
  if (is_own && !options.looks.empty()) looks.samples = options.looks;
  const MatchStarts starts = match_starts_of(options);
  const SiteMeasuring measuring{
      options.reference, localization_drive, in_map, starts, std::move(looks), ctx.seed};
  SIGHTLINE_ASSIGN(std::vector<std::optional<std::size_t>> scans,
                   scans_of_sites(ctx, options, measuring, sites));
  thin_sites(static_cast<std::size_t>(site_step_of(options)), scans);
  const ByFamily<MeasuredError> empty =
      empty_result(measuring, matching_card(options, nds.head().cell_m), scans);
  Localizing localizing(options, localization_drive.sensor, nds,
                        {options.localizer, options.coarse_cells,
                         reach_of_localizer_m(options.localizer, measuring), ctx.threads});
  return measure_sites(ctx, measuring, localizing, scans, empty);
}

}  // namespace sightline
