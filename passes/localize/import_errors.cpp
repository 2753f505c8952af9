#include "passes/localize/import_errors.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <span>

#include "formats/base/parallel.h"
#include "formats/base/statistics.h"
#include "formats/drive/trajectory.h"
#include "formats/grid/point_grid.h"
#include "passes/localize/measure_site.h"
#include "passes/pass/scan_selection.h"

namespace sightline {
namespace {

// A scan and what the file says of it: errors ascending by range and start.
struct ImportedScan {
  std::size_t scan = 0;  // position in the drive
  std::span<const OutsideError> errors;
};

Error mismatched(const OutsideError& at, const std::string& message) {
  return {ErrorCode::kMismatchedInputs, message, "", concat("line ", at.line)};
}

std::string text_of(const std::vector<double>& ranges_m) {
  std::string text;
  for (const double range_m : ranges_m) {
    text += (text.empty() ? "" : ", ") + format_double(range_m);
  }
  return text + " m";
}

// Every range with the starts 0, 1, ... up to `start_count`, and nothing else.
Result<void> check_complete(const ImportErrorsOptions& options,
                            std::span<const OutsideError> of_scan, std::size_t start_count) {
  for (const OutsideError& error : of_scan) {
    if (std::ranges::find(options.ranges_m, error.range_m) != options.ranges_m.end()) continue;
    return mismatched(
        error, concat("found a look of ", format_double(error.range_m),
                      " m, expected one of annotation.ranges_m: ", text_of(options.ranges_m)));
  }
  for (std::size_t i = 0; i < options.ranges_m.size() * start_count; ++i) {
    const double range_m = options.ranges_m[i / start_count];
    const std::size_t start = i % start_count;
    const bool is_there =
        i < of_scan.size() && of_scan[i].range_m == range_m && of_scan[i].start == start;
    if (is_there) continue;
    return mismatched(of_scan[std::min(i, of_scan.size() - 1)],
                      concat("scan ", of_scan.front().scan, " has no error for a look of ",
                             format_double(range_m), " m and start ", start,
                             ". Every scan needs the same starts, from 0 on, at each of ",
                             text_of(options.ranges_m)));
  }
  if (of_scan.size() == options.ranges_m.size() * start_count) return {};
  return mismatched(of_scan.back(),
                    concat("scan ", of_scan.front().scan,
                           " has more starts than the first scan, which has ", start_count));
}

// The drive's position of each recording index that may be localized.
std::map<std::uint32_t, std::size_t> scans_by_index(const ImportErrorsOptions& options,
                                                    const Drive& drive) {
  std::map<std::uint32_t, std::size_t> scans;
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    if (is_selected(drive.scans[i], options.scans)) scans[drive.scans[i].recording_index] = i;
  }
  return scans;
}

std::size_t start_count_of(std::span<const OutsideError> errors) {
  std::size_t count = 0;
  while (count < errors.size() && errors[count].scan == errors.front().scan &&
         errors[count].range_m == errors.front().range_m) {
    ++count;
  }
  return count;
}

Result<std::vector<ImportedScan>> imported_scans(const ImportErrorsOptions& options,
                                                 const Drive& drive, const OutsideErrors& outside) {
  const std::map<std::uint32_t, std::size_t> scans = scans_by_index(options, drive);
  const std::span<const OutsideError> all(outside.errors);
  const std::size_t start_count = start_count_of(all);
  std::vector<ImportedScan> imported;
  for (std::size_t first = 0, last = 0; first < all.size(); first = last) {
    while (last < all.size() && all[last].scan == all[first].scan) ++last;
    const auto found = scans.find(all[first].scan);
    if (found == scans.end()) {
      const std::string of_which =
          options.scans == ScanSelection::kAll
              ? "scans"
              : std::string(name_of(options.scans)) + " scans (the others made the map)";
      return mismatched(
          all[first], concat("found scan ", all[first].scan, ", expected one of the ", scans.size(),
                             " ", of_which, " of drive '", drive.name, "'"));
    }
    const std::span<const OutsideError> of_scan = all.subspan(first, last - first);
    SIGHTLINE_TRY(check_complete(options, of_scan, start_count));
    imported.push_back({found->second, of_scan});
  }
  return imported;
}

ErrorRow row_of(std::span<const OutsideError> starts) {
  std::vector<double> errors_m;
  std::size_t lost_count = 0;
  for (const OutsideError& error : starts) {
    errors_m.push_back(error.error_m);
    if (error.error_m > kLostBeyond_m) ++lost_count;
  }
  ErrorRow row;
  const auto count = static_cast<double>(errors_m.size());
  row.mean_m = ordered_sum(errors_m) / count;
  row.from_given_m = row.mean_m;
  row.lost_share = static_cast<double>(lost_count) / count;
  std::ranges::sort(errors_m);
  row.median_m = quantile_of_sorted(errors_m, 0.5);
  row.p90_m = quantile_of_sorted(errors_m, 0.9);
  row.max_m = errors_m.back();
  return row;
}

// For each site, the nearest of the imported scans on its level, the first on a tie.
std::vector<std::optional<std::size_t>> nearest_imported(const ImportErrorsOptions& options,
                                                         const std::vector<ImportedScan>& imported,
                                                         const Trajectory& in_map,
                                                         const Sites& sites) {
  std::vector<Eigen::Vector3d> places_m;
  for (const ImportedScan& scan : imported) {
    places_m.push_back(in_map.poses[scan.scan].T_map_vehicle.translation());
  }
  const PointGrid grid(places_m);
  std::vector<std::optional<std::size_t>> taken;
  for (const Site& site : sites.sites) {
    const std::optional<NearPoint> nearest =
        grid.nearest_on_level(site.T_map_vehicle.translation(), options.site_radius_m);
    taken.push_back(nearest ? std::optional(nearest->index) : std::nullopt);
  }
  return taken;
}

void warn_of_unused(const PassContext& ctx, const std::vector<std::optional<std::size_t>>& taken,
                    std::size_t told_count, const ImportErrorsOptions& options) {
  std::vector<std::uint8_t> is_used(told_count, 0);
  for (const std::optional<std::size_t>& imported : taken) {
    if (imported) is_used[*imported] = 1;
  }
  const auto unused = std::ranges::count(is_used, std::uint8_t{0});
  if (unused == 0) return;
  ctx.warn(concat(unused, " of ", told_count,
                  " imported scans are not the nearest scan of any site within ",
                  format_double(options.site_radius_m), " m; their errors are not used"));
}

std::size_t count_taken(const std::vector<std::optional<std::size_t>>& taken) {
  return taken.size() -
         static_cast<std::size_t>(std::count(taken.begin(), taken.end(), std::nullopt));
}

// A measured scan stands for so many sites; beyond this two measured places say little of what is
// between.
std::uint32_t site_step_of(const std::vector<std::optional<std::size_t>>& taken) {
  constexpr std::size_t kMostSites = 20;
  std::set<std::size_t> scans;
  for (const std::optional<std::size_t>& scan : taken) {
    if (scan) scans.insert(*scan);
  }
  const std::size_t measured = scans.size();
  return static_cast<std::uint32_t>(
      std::clamp<std::size_t>((taken.size() + measured / 2) / measured, 1, kMostSites));
}

}  // namespace

std::vector<OptionField> option_fields(ImportErrorsOptions& options) {
  return {shared(numbers("ranges_m", options.ranges_m, "ranges at which errors are given, m", 1.0,
                         1000.0)),
          scans_option(options.scans),
          shared(number("site_radius_m", options.site_radius_m,
                        "largest distance from a site to its scan, m", 0.01, 100.0))};
}

Result<ByFamily<MeasuredError>> import_errors(PassContext& ctx, const ImportErrorsOptions& options,
                                              const OutsideErrors& outside, const Drive& drive,
                                              const Trajectory& trajectory, const Sites& sites) {
  SIGHTLINE_TRY(check_trajectory_of_drive(drive, trajectory));
  const Result<std::vector<ImportedScan>> found = imported_scans(options, drive, outside);
  if (!found) return in_file(found.error(), outside.file);
  const std::vector<ImportedScan>& imported = *found;
  const std::vector<std::optional<std::size_t>> taken =
      nearest_imported(options, imported, rebase(trajectory, sites.frame), sites);
  if (count_taken(taken) == 0) {
    return Error{ErrorCode::kNoOverlap,
                 concat("none of ", taken.size(), " sites has one of the ", imported.size(),
                        " imported scans of drive '", drive.name, "' within ",
                        format_double(options.site_radius_m), " m"),
                 "", "pass import-errors"};
  }
  warn_of_unused(ctx, taken, imported.size(), options);
  const std::size_t start_count = start_count_of(outside.errors);
  MeasuredError measured;
  measured.drive = drive.name;
  measured.matching = {options.scans, outside.localizer, 1, 0.0, site_step_of(taken)};
  measured.reference = outside.reference;
  measured.looks = every_return_at(options.ranges_m);
  for (const std::optional<std::size_t>& scan : taken) {
    measured.scan_of_site.push_back(
        scan ? std::int64_t{drive.scans[imported[*scan].scan].recording_index} : -1);
    for (std::size_t range = 0; range < options.ranges_m.size(); ++range) {
      measured.rows.push_back(
          scan ? row_of(imported[*scan].errors.subspan(range * start_count, start_count))
               : ErrorRow{});
    }
  }
  return ByFamily<MeasuredError>(std::move(measured));
}

}  // namespace sightline
