#include "passes/model/history_of_map.h"

#include <cstdint>
#include <optional>
#include <string>

#include "passes/model/forest/history.h"
#include "passes/model/forest/measured_columns.h"

namespace sightline {
namespace {

// [site]: the site of the map that speaks for it.
using Speakers = std::vector<std::optional<std::size_t>>;

Speakers speakers_of(const MeasuredError& drive, const Sites& of_map, const Sites& sites,
                     double radius_m) {
  const MeasuredPlaces measured = places_measured_by(drive, of_map);
  Speakers speakers;
  for (const Site& site : sites.sites) {
    const std::optional<NearPoint> near = measured.grid.nearest_on_level(site.p_map_m, radius_m);
    speakers.push_back(near ? std::optional(measured.sites[near->index]) : std::nullopt);
  }
  return speakers;
}

// The rows of a drive at other sites.
MeasuredError at_sites(const MeasuredError& drive, const Speakers& speakers,
                       const MeasuredError& like) {
  MeasuredError moved;
  moved.drive = drive.drive;
  moved.matching = like.matching;
  moved.looks = drive.looks;
  moved.offsets = like.offsets;
  moved.rows.resize(moved.shape().size(speakers.size()));
  for (std::size_t site = 0; site < speakers.size(); ++site) {
    moved.scan_of_site.push_back(speakers[site] ? 0 : -1);
    for (std::size_t look = 0; speakers[site] && look < moved.looks.size(); ++look) {
      moved.rows[moved.shape().index(site, look)] = drive.row(*speakers[site], look);
    }
  }
  return moved;
}

ByFamily<MeasuredError> at_sites(const ByFamily<MeasuredError>& drive, const Speakers& speakers,
                                 const ByFamily<MeasuredError>& like) {
  ByFamily<MeasuredError> moved(at_sites(drive.ranges, speakers, like.ranges));
  if (drive.samples) moved.samples = at_sites(*drive.samples, speakers, *like.samples);
  return moved;
}

// Why what the map keeps of a drive says nothing here; empty: it does.
std::string reason_to_leave_out(const ByFamily<MeasuredError>& drive, const CompiledMap& map,
                                const SensorProfile& sensor, const ByFamily<MeasuredError>& like) {
  if (to_bytes(map.sensor) != to_bytes(sensor)) {
    return concat("its sensor was ", map.sensor.name,
                  ", or had another mounting on the vehicle, and here it is ", sensor.name);
  }
  const LocalizerProfile& localizer = like.ranges.matching.localizer;
  if (map.model.localizer != localizer) {
    return concat("it was localized by ", to_text(map.model.localizer), ", here it is ",
                  to_text(localizer));
  }
  return has_looks_of(drive, like) ? "" : "it was measured at other ranges or looks";
}

// Adds those of the map behind the drives that are there.
Result<void> add_those_of_map(const PassContext& ctx, const HistoryOfMapOptions& options,
                              const CompiledMap& map, const Sites& sites,
                              const SensorProfile& sensor, const ByFamily<MeasuredError>& like,
                              MeasuredDrives& drives) {
  if (!(map.sites.frame == sites.frame)) {
    return Error{ErrorCode::kMismatchedInputs, "the map's sites are in another frame", "",
                 "pass history-of-map"};
  }
  const std::vector<ByFamily<MeasuredError>> known = measured_of_columns(factors_of(map));
  for (std::size_t i = 0; i < known.size(); ++i) {
    ByFamily<MeasuredError> drive = known[i];
    visit_families(drive, [&](MeasuredError& of_family) {
      of_family.drive = concat("drive ", i + 1, " of the map");
    });
    const std::uint32_t number = drives.named_count++;
    const std::string reason = reason_to_leave_out(drive, map, sensor, like);
    if (!reason.empty()) {
      ctx.warn(concat("the errors that the earlier map contains for its drive ", i + 1,
                      " are not used: ", reason));
      continue;
    }
    drives.drives.push_back(
        at_sites(drive, speakers_of(drive.ranges, map.sites, sites, options.site_radius_m), like));
    drives.numbers.push_back(number);
  }
  return {};
}

}  // namespace

std::vector<OptionField> option_fields(HistoryOfMapOptions& options) {
  return {shared(number("site_radius_m", options.site_radius_m,
                        "largest distance from a measured site to the sites that take its error, m",
                        0.0, 100.0))};
}

Result<MeasuredDrives> history_of_map(PassContext& ctx, const HistoryOfMapOptions& options,
                                      const CompiledMap& map, const Sites& sites,
                                      const SensorProfile& sensor,
                                      const ByFamily<MeasuredError>& measured,
                                      const MeasuredDrives* now) {
  MeasuredDrives drives;
  if (now != nullptr) {
    drives = *now;
    if (drives.drives.empty()) return drives;  // looks and localizer of errors here are unknown
  } else if (measured.ranges.reference != ErrorReference::kSimulated) {
    drives = {{measured}, {0}, 1};
  }
  const ByFamily<MeasuredError> like = drives.drives.empty() ? measured : drives.drives.front();
  SIGHTLINE_TRY(add_those_of_map(ctx, options, map, sites, sensor, like, drives));
  return drives;
}

}  // namespace sightline
