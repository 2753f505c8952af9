#include "compiler/views/text/describe.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>

#include "formats/base/printable.h"
#include "formats/model/place_kind.h"
#include "formats/text/numbers.h"

namespace sightline {
namespace {

std::string percent_of(std::size_t part, std::size_t whole) {
  return percent(whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole));
}

std::string field(const char* name, const std::string& value) {
  return fmt::format("  {:22} {}\n", name, one_line(value));
}

// Share of the sites with answers from simulated scans; empty if there are none.
std::string describe_simulated(const CompiledMap& map) {
  const std::uint32_t count = simulated_site_count(map.ranges);
  if (count == 0) return "";
  return field("simulated", percent_of(count, map.sites.sites.size()) +
                                " of sites: no scan was recorded there, only simulated ones");
}

std::string describe_map(const CompiledMap& map) {
  const Eigen::Vector3d& origin_m = map.ndt.frame.origin_world_m;
  const std::size_t runs =
      map.sites.sites.empty() ? 0 : map.sites.sites.back().run + std::size_t{1};
  return concat(
      "map ", one_line(map.map_id), "\n",
      field("version", fmt::format("{}, release {}", map.version, map.release)),
      field("written by", map.writer),
      field("frame", fmt::format("world minus ({:.15g}, {:.15g}, {:.15g}) m", origin_m.x(),
                                 origin_m.y(), origin_m.z())),
      field("world",
            map.world == kLocalWorld ? "local: the recording's own coordinates" : map.world),
      field("NDs", fmt::format("{} of {:g} m, from {} points; {} cells too sparse, {} flat",
                               map.ndt.nds.size(), map.ndt.cell_m, map.ndt.point_count,
                               map.ndt.sparse_cell_count, map.ndt.degenerate_cell_count)),
      field("sites", fmt::format("{}, every {:g} m, in {} {} of {:.0f} m together",
                                 map.sites.sites.size(), map.sites.spacing_m, runs,
                                 runs == 1 ? "run" : "runs", route_length_m(map.sites))),
      field("reach", fmt::format("{:g} m around a site", map.reach_m)), describe_simulated(map));
}

// Whom the map's probabilities are for, and who was measured where that is another.
std::string describe_localizer(const CompiledMap& map) {
  const LocalizerProfile& of_map = map.model.localizer;
  std::string text =
      field("localizer", localizer_title(of_map) + ": ranges and probabilities are for it alone");
  const std::string parameters = parameters_text(of_map);
  if (!parameters.empty()) text += field("", parameters);
  if (map.measurement.localizer == of_map) return text;
  return text + field("measured here",
                      concat("by ", to_text(map.measurement.localizer), ", not the one above"));
}

// Nothing of a trajectory of one piece that was given.
std::string describe_pieces(const TrajectoryQuality& trajectory, const MapFrame& frame) {
  std::string text;
  const std::size_t count = trajectory.pieces.size();
  if (count > 1) {
    text += field("pieces", fmt::format("{}; their relative poses are unknown", count));
  }
  for (std::size_t i = 0; count > 1 && i < count; ++i) {
    const TrajectoryPiece& piece = trajectory.pieces[i];
    const Eigen::Vector3d begin_m = frame.world_m(piece.begin_map_m);
    text += field(
        "", fmt::format("{}: from scan {} at {:.3f} s, {} scans, {:.1f} m long, from ({:.1f}, "
                        "{:.1f}, {:.1f}) m in the world",
                        i, piece.first_scan, 1e-9 * static_cast<double>(piece.stamp_ns),
                        piece.scan_count, piece.way_m, begin_m.x(), begin_m.y(), begin_m.z()));
  }
  if (trajectory.overlap_count == 0) return text;
  return text +
         field("overlap", fmt::format("median {:.0f} %, least {:.0f} % of {} scans",
                                      100.0 * trajectory.median_overlap,
                                      100.0 * trajectory.least_overlap, trajectory.overlap_count));
}

std::string describe_unconstrained(const TrajectoryQuality& trajectory) {
  std::string text;
  for (const UnconstrainedStretch& stretch : trajectory.unconstrained) {
    text += field(text.empty() ? "unconstrained" : "", to_text(stretch));
  }
  return text;
}

std::string describe_notices(const std::vector<Notice>& notices) {
  std::string text = "contradictions in the inputs that were accepted\n";
  for (const Notice& notice : notices) text += field(notice.code.c_str(), notice.text);
  return text;
}

std::string describe_trajectory(const TrajectoryQuality& trajectory, const MapFrame& frame) {
  static constexpr std::array kSources = {"as given", "given, then refined", "estimated"};
  std::string text = field("poses", kSources[static_cast<std::size_t>(trajectory.source)]) +
                     describe_pieces(trajectory, frame) + describe_unconstrained(trajectory);
  if (trajectory.odometry_edges == 0) return text;
  return text +
         field("pose graph",
               fmt::format("{} steps, {} loops; residuals {:.1f} cm and {:.3f} degrees (RMS)",
                           trajectory.odometry_edges, trajectory.loop_edges,
                           100.0 * trajectory.rms_translation_residual_m,
                           trajectory.rms_rotation_residual_rad * 180.0 / std::numbers::pi));
}

std::string describe_sensor(const SensorProfile& sensor) {
  const std::string beams = fmt::format("{}, {} beams", sensor.name, sensor.ring_count());
  if (sensor.sees_all_round()) return beams;
  return beams + fmt::format(", {:.1f} degrees of a turn", sensor.azimuth_view_deg);
}

// Nothing where no tracking start was measured.
std::string describe_tracking(const MeasurementCard& card) {
  if (card.tracking_looks.empty()) return "";
  std::string looks;
  for (const Look& look : card.tracking_looks) looks += (looks.empty() ? "" : "; ") + to_text(look);
  return field("tracking", fmt::format("{} starts at every site; columns of {}",
                                       card.tracking_offsets.size(), looks));
}

std::string describe_measurement(const CompiledMap& map) {
  const MeasurementCard& card = map.measurement;
  if (card.reference == ErrorReference::kSimulated) {
    return concat("simulated error\n", field("map", card.mapping_drive + ", a finished map"),
                  field("localization", "no drive was here"), describe_localizer(map),
                  field("offsets", fmt::format("{} starts at every site", card.offsets.size())),
                  field("sensor", describe_sensor(map.sensor)));
  }
  const bool is_known = card.reference == ErrorReference::kKnownPose;
  return concat(
      "measured error\n",
      field("mapping", card.mapping_drive + ", " + card.mapping_scans + " scans"),
      field("localization", card.localization_drive + ", " + card.localization_scans + " scans"),
      field("reference", is_known ? "known poses" : "match at the sensor's full range"),
      describe_localizer(map),
      field("offsets", card.offsets.empty()
                           ? "unknown: the errors were imported"
                           : fmt::format("{} starts at every site", card.offsets.size())),
      describe_tracking(card),
      field("measured sites",
            fmt::format("{} of {}", card.measured_site_count, map.sites.sites.size())),
      field("sensor", describe_sensor(map.sensor)));
}

std::string describe_promise(const LimitPromise& promise, bool is_simulated) {
  const bool is_of_next_drive = promise.scope == PromiseScope::kNextDrive;
  std::string text = field("promise", promise.is_earned  ? "for the next drive"
                                      : is_of_next_drive ? "none for the next drive"
                                      : is_simulated     ? "none: figures of simulated scans"
                                                         : "none: figures of this drive");
  if (!promise.statement.empty()) text += field("", promise.statement);
  if (promise.is_earned) {
    text += field("coverage promised", percent(1.0 - promise.alpha) + " of the answered sites");
  }
  return text +
         field("p*", fmt::format("{:.4f} ({}; blocks {}, places {}, drives {})",
                                 promise.probability_threshold, promise.method, promise.block_count,
                                 promise.place_count, promise.drive_count));
}

std::string histogram(const RangeTable& ranges, std::size_t limit) {
  std::vector<std::size_t> counts(ranges.looks.size(), 0);
  for (std::size_t site = 0; site < ranges.site_count; ++site) ++counts[ranges.range(site, limit)];
  std::string text;
  constexpr double kWidth = 40.0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const double share = static_cast<double>(counts[i]) / static_cast<double>(ranges.site_count);
    text += fmt::format("    {:>7} {:7}  {:>5.1f} %  {:#<{}}\n", to_text(ranges.looks[i]),
                        counts[i], 100.0 * share, "", std::lround(kWidth * share));
  }
  return text;
}

// Sites that take the street's own static answer.
std::uint32_t static_count(const RangeTable& ranges, std::size_t limit) {
  std::uint32_t count = 0;
  for (std::size_t site = 0; site < ranges.site_count; ++site) {
    count += (ranges.flags_of(site, limit) & kStatic) != 0 ? 1 : 0;
  }
  return count;
}

// Of the ranges, or of the looks that take a sample.
std::string describe_limit(const CompiledMap& map, const RangeTable& ranges,
                           const LimitQuality& quality, std::size_t limit) {
  const LimitPromise& promise = ranges.promises[limit];
  const std::size_t sites = map.sites.sites.size();
  const bool is_simulated = map.measurement.reference == ErrorReference::kSimulated;
  std::string text =
      fmt::format("limit {:g} m\n", promise.limit_m) + describe_promise(promise, is_simulated);
  text += field("coverage expected", percent(quality.expected_coverage));
  if (map.measurement.measured_site_count > 0) {
    text += field("coverage measured", percent(quality.measured_coverage) +
                                           " of the sites that the localization drive passed");
  }
  if (takes_every_return(ranges.looks.front())) {
    text += field("mean range", fmt::format("{:.1f} m", quality.mean_range_m));
  }
  text += field("unmet", percent_of(quality.unmet_count, sites) + " of sites: not answered");
  text += field("extrapolated", percent_of(quality.extrapolated_count, sites) + " of sites");
  text += field("static", percent_of(static_count(ranges, limit), sites) + " of sites");
  return text + histogram(ranges, limit);
}

// [kind]: its sites.
std::array<std::vector<std::size_t>, kPlaceKindCount> sites_by_kind(const CompiledMap& map) {
  std::array<std::vector<std::size_t>, kPlaceKindCount> sites;
  for (std::size_t site = 0; site < map.sites.sites.size(); ++site) {
    sites[static_cast<std::size_t>(kind_at(map.columns, site))].push_back(site);
  }
  sites.front().clear();  // unknown
  return sites;
}

std::string describe_kinds(const CompiledMap& map) {
  std::string shares;
  const auto by_kind = sites_by_kind(map);
  for (std::size_t kind = 0; kind < by_kind.size(); ++kind) {
    if (by_kind[kind].empty()) continue;
    shares += concat((shares.empty() ? "" : ", "), name_of(static_cast<PlaceKind>(kind)), " ",
                     percent_of(by_kind[kind].size(), map.sites.sites.size()));
  }
  return shares.empty() ? "" : field("kinds of place", shares);
}

// Where kinds of place have different looks: each with the look of its first site.
std::string describe_looks_of_kinds(const CompiledMap& map, std::size_t limit) {
  std::string text;
  std::set<std::size_t> different;
  const auto by_kind = sites_by_kind(map);
  for (std::size_t kind = 0; kind < by_kind.size(); ++kind) {
    if (by_kind[kind].empty()) continue;
    const std::size_t look = map.looks->ranges.range(by_kind[kind].front(), limit);
    different.insert(look);
    text += field(concat("in ", name_of(static_cast<PlaceKind>(kind))).c_str(),
                  to_text(map.looks->ranges.looks[look]));
  }
  return different.size() > 1 ? text : "";
}

// What most vehicles ask for.
std::string describe_looks(const CompiledMap& map) {
  if (!map.looks) return "";
  const auto& [predicted, looks, quality, factors] = *map.looks;
  std::string text = "looks\n" + field("what",
                                       "the cheapest way to localize: a range, and the sample of "
                                       "a scan that is matched");
  for (std::size_t limit = 0; limit < looks.promises.size(); ++limit) {
    text += describe_limit(map, looks, quality[limit], limit);
    text += describe_looks_of_kinds(map, limit);
  }
  if (looks.plan) text += field("while tracking", to_text(*looks.plan));
  return text;
}

// Three digits where the card has seventeen.
std::string describe_figure(const CardFigure& figure) {
  switch (figure.kind) {
    case CardFigureKind::kRSquared:
      return field((concat("R^2 at ", figure.of, " m")).c_str(),
                   fmt::format("{:.2f}", figure.value));
    case CardFigureKind::kRmse_m:
      return field((concat("RMSE at ", figure.of, " m")).c_str(),
                   fmt::format("{:.1f} cm", 100.0 * figure.value));
    case CardFigureKind::kImportance_m:
      break;
  }
  return field(("of " + figure.of).c_str(),
               fmt::format("{:.2f} mm importance", 1000.0 * figure.value));
}

std::string describe_model(const ModelRecord& model) {
  std::string text = concat("error model\n", field("sha256", to_hex(model.digest)),
                            field("in this map", model.bytes.empty() ? "no, stripped" : "yes"));
  auto figure = model.figures.begin();
  for (std::size_t fact = 0; fact < model.card.size(); ++fact) {
    const bool is_figure = figure != model.figures.end() && figure->fact == fact;
    const auto& [name, value] = model.card[fact];
    text += is_figure ? describe_figure(*figure++) : field(name.c_str(), value);
  }
  return text;
}

}  // namespace

std::string describe(const CompiledMap& map) {
  std::string text = describe_map(map) + describe_measurement(map);
  if (map.trajectory) text += describe_trajectory(*map.trajectory, map.ndt.frame);
  if (!map.notices.empty()) text += describe_notices(map.notices);
  if (map.tile_drives) text += describe_drives(*map.tile_drives);
  if (map.sharpness) text += to_text(*map.sharpness) + "\n";
  text += "ranges\n" +
          field("rule", fmt::format("{}, dilated by {:g} m", name_of(map.ranges.selection),
                                    map.ranges.dilation_m)) +
          describe_kinds(map);
  for (std::size_t limit = 0; limit < map.ranges.promises.size(); ++limit) {
    text += describe_limit(map, map.ranges, map.quality[limit], limit);
  }
  text += describe_looks(map);
  text += describe_model(map.model) + "definitions\n";
  for (const NamedVersion& definition : map.definitions) {
    text += field(definition.name.c_str(), fmt::format("v{}", definition.version));
  }
  return text;
}

std::string judged_by(const LocalizerProfile& of_map, const LocalizerProfile& judging) {
  if (judging == of_map) return "";
  return concat("Judged by ", to_text(judging), "; the map's ranges and probabilities are for ",
                to_text(of_map), "\n\n");
}

std::string describe(const ByFamily<ErrorModel>& model) {
  const ModelRecord record = record_of(model);
  return concat("error model\n", field("sha256", to_hex(record.digest)),
                field("encoding", std::to_string(record.encoding_version)), "\n", to_text(model));
}

std::string describe(const MapSummary& summary) {
  std::string text = concat(
      "file\n", field("format", summary.format), field("root digest", to_hex(summary.root_digest)),
      field("size", fmt::format("{} bytes, {} tiles", summary.file_size, summary.tile_count)));
  text += fmt::format("    {:14} {:>8} {:>10} {:>12} {:>12}\n", "part", "blocks", "rows",
                      "raw bytes", "stored bytes");
  const auto line = [&](const std::string& name, std::uint64_t blocks, std::uint64_t rows,
                        std::uint64_t raw, std::uint64_t stored) {
    text += fmt::format("    {:14} {:8} {:10} {:12} {:12}\n", name, blocks, rows, raw, stored);
  };
  line("manifest", 1, 1, summary.manifest_size, summary.manifest_size);
  for (const MapSummary::Blocks& blocks : summary.blocks) {
    line(blocks.name, blocks.block_count, blocks.row_count, blocks.raw_size, blocks.stored_size);
  }
  line("directory", 1, 1, summary.directory_size, summary.directory_size);
  return text;
}

std::string describe_drives(const TileDrives& tiles) {
  constexpr std::size_t kNameWidth = 22;  // as the other fields that `inspect` prints
  std::string text = "drives\n";
  for (std::uint32_t i = 0; i < tiles.drives.size(); ++i) {
    const MappedDrive& drive = tiles.drives[i];
    const std::string day = day_of(drive.begin_ns);
    const auto tiles_with = [&](std::uint32_t TileDrive::*count) {
      return std::ranges::count_if(
          tiles.rows, [&](const TileDrive& row) { return row.drive == i && row.*count > 0; });
    };
    const auto confirmed = tiles_with(&TileDrive::confirming_scan_count);
    std::string name = drive.name;
    name.resize(std::max(kNameWidth, name.size()), ' ');
    text += concat("  ", name, " ", (day.empty() ? "day not known" : day), ", in ",
                   tiles_with(&TileDrive::scan_count), " tiles");
    if (confirmed > 0) text += concat(", nothing new in ", confirmed);
    text += "\n";
  }
  return text;
}

}  // namespace sightline
