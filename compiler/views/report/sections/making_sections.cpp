#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "compiler/views/report/sections/sections.h"
#include "formats/base/hash.h"
#include "formats/base/units.h"
#include "formats/text/json_text.h"

namespace sightline {
namespace {

constexpr std::array<const char*, 3> kSourceWords = {  // by PoseSource
    "as given with the recording", "given, and refined by the scans", "estimated from the scans"};

// 0 between pieces, whose distance has no meaning.
double step_m(const Trajectory& trajectory, std::size_t i) {
  if (i == 0 || trajectory.poses[i].piece != trajectory.poses[i - 1].piece) return 0.0;
  return (trajectory.poses[i].T_map_vehicle.translation() -
          trajectory.poses[i - 1].T_map_vehicle.translation())
      .norm();
}

std::string pieces_table(const TrajectoryQuality& quality, const MapFrame& frame) {
  if (quality.pieces.size() < 2) return "";
  TextGrid grid = {{"piece", "first scan", "time (s)", "scans", "way (m)", "begins at, world (m)"}};
  for (std::size_t i = 0; i < quality.pieces.size(); ++i) {
    const TrajectoryPiece& piece = quality.pieces[i];
    const Eigen::Vector3d at_m = frame.world_m(piece.begin_map_m);
    grid.push_back(
        {std::to_string(i), std::to_string(piece.first_scan),
         fixed(1e-9 * static_cast<double>(piece.stamp_ns), 3), std::to_string(piece.scan_count),
         fixed(piece.way_m, 1),
         concat(fixed(at_m.x(), 1), ", ", fixed(at_m.y(), 1), ", ", fixed(at_m.z(), 1))});
  }
  return html_table(grid,
                    "Pieces of the trajectory. Their relative position is unknown: they are placed "
                    "side by side, and distances between pieces have no meaning");
}

std::string unconstrained_table(const std::vector<UnconstrainedStretch>& stretches) {
  if (stretches.empty()) return "";
  TextGrid grid = {
      {"scans", "way (m)", "not constrained", "used instead", "1 sigma at the end (m)"}};
  for (const UnconstrainedStretch& stretch : stretches) {
    grid.push_back({fmt::format("{} to {}", stretch.first_scan, stretch.last_scan),
                    fixed(stretch.way_m, 1), directions_text(stretch.directions),
                    std::string(name_of(stretch.directions.substitute)),
                    stretch.sigma_m ? fixed(*stretch.sigma_m, 1) : "unknown"});
  }
  return html_table(grid,
                    "Stretches of the way that scans do not constrain: poses there rest on what is "
                    "used instead, and distances along them are as uncertain");
}

std::string notices_table(const std::vector<Notice>& notices) {
  if (notices.empty()) return "";
  Facts facts;
  for (const Notice& notice : notices) facts.emplace_back(notice.code, notice.text);
  return "<h3>Contradictions in the inputs that were accepted</h3>\n" + fact_table(facts);
}

std::string trajectory_facts(const Trajectory& trajectory) {
  double way_m = 0.0;
  for (std::size_t i = 0; i < trajectory.poses.size(); ++i) way_m += step_m(trajectory, i);
  const TrajectoryQuality quality = quality_of(trajectory);
  Facts facts = {{"poses", fmt::format("{}, {}", trajectory.poses.size(),
                                       kSourceWords[static_cast<std::size_t>(trajectory.source)])},
                 {"way", fixed(way_m, 1) + " m"}};
  if (quality.overlap_count > 0) {
    facts.emplace_back("overlap with earlier scans",
                       fmt::format("median {:.0f} %, least {:.0f} %",
                                   100.0 * quality.median_overlap, 100.0 * quality.least_overlap));
  }
  if (trajectory.odometry_edges > 0) {
    facts.emplace_back(
        "pose graph",
        fmt::format("{} odometry edges, {} loop closures, {} given poses",
                    trajectory.odometry_edges, trajectory.loop_edges, trajectory.prior_edges));
    facts.emplace_back(
        "residuals (RMS)",
        fmt::format("{:.1f} cm, {:.3f}°", 100.0 * trajectory.rms_translation_residual_m,
                    kDegPerRad * trajectory.rms_rotation_residual_rad));
  }
  return fact_table(facts) + pieces_table(quality, trajectory.frame);
}

std::string uncertainty_figure(const Trajectory& trajectory) {
  Chart chart = {"Standard deviation of the poses along the drive", "distance along the drive (m)",
                 "standard deviation (cm)", 1080.0, 200.0};
  chart.least_y = 0.0;
  ChartSeries level = {"horizontal", kBlue};
  ChartSeries height = {"vertical", kOrange, Mark::kLine, 1.6, true};
  double way_m = 0.0;
  for (std::size_t i = 0; i < trajectory.poses.size(); ++i) {
    const TrajectoryPose& pose = trajectory.poses[i];
    way_m += step_m(trajectory, i);
    level.add(way_m, 100.0 * std::sqrt(pose.covariance(0, 0) + pose.covariance(1, 1)));
    height.add(way_m, 100.0 * std::sqrt(pose.covariance(2, 2)));
  }
  chart.series = {level, height};
  return html_figure({"trajectory", "Trajectory.",
                      "Standard deviation of the poses of the map relative to the first pose of "
                      "their piece, from the least-squares adjustment.",
                      chart_svg(chart), ""});
}

std::string sharpness_table(const Sharpness& sharpness) {
  TextGrid grid = {{"poses", "mean map entropy (nat)", "points", "mean plane deviation (cm)",
                    "points in planes"}};
  const auto append = [&](const std::string& name, const SharpnessFigures& figures) {
    grid.push_back({name, fixed(figures.mean_entropy_nat, 3),
                    std::to_string(figures.entropy_points),
                    in_centimetres(std::sqrt(figures.mean_plane_variance_m2)),
                    std::to_string(figures.plane_points)});
  };
  append("poses of the map", sharpness.of_map);
  if (sharpness.of_given) append("given poses", *sharpness.of_given);
  return html_table(grid, "Sharpness of the map with these poses; smaller is sharper");
}

std::string moving_facts(const SurfacePoints& points) {
  if (points.voxel_m == 0.0) return paragraph("Moving objects were not searched for.");
  const double all = static_cast<double>(points.standing_count + points.moving_count);
  const double percent = all > 0.0 ? 100.0 * static_cast<double>(points.moving_count) / all : 0.0;
  return fact_table(
      {{"removed as moving",
        fmt::format("{} returns ({:.2f} %) in {} voxels of {}", points.moving_count, percent,
                    points.moved_voxels.size(), metres(points.voxel_m))},
       {"kept as static", fmt::format("{} returns", points.standing_count)},
       {"beyond the sensor's range", fmt::format("{} returns", points.out_of_range_count)}});
}

using Json = nlohmann::ordered_json;

Result<Json> provenance_of(const ReportSources& sources) {
  Json json = Json::parse(sources.provenance, nullptr, false);
  if (json.is_object()) return json;
  return Error{ErrorCode::kMalformedText, "the provenance beside the map is not a JSON object",
               sources.map_file + ".provenance.json"};
}

std::string text_of(const Json& value) {
  return value.is_string() ? value.get<std::string>() : json_text(value, -1);
}

double number_of(const Json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_number() ? found->get<double>() : 0.0;
}

std::string list_of(const Json& object, const char* name) {
  std::string text;
  const auto found = object.find(name);
  if (found == object.end() || !found->is_array()) return text;
  for (const Json& item : *found) text += (text.empty() ? "" : "; ") + text_of(item);
  return text;
}

std::string pass_table(const Json& passes) {
  TextGrid grid = {
      {"pass", "wall time (s)", "CPU time (s)", "peak memory (MiB)", "from the cache"}};
  double wall_s = 0.0;
  double cpu_s = 0.0;
  for (const Json& pass : passes) {
    wall_s += number_of(pass, "wall_s");
    cpu_s += number_of(pass, "cpu_s");
    grid.push_back({text_of(pass.value("name", Json(""))), fixed(number_of(pass, "wall_s"), 2),
                    fixed(number_of(pass, "cpu_s"), 2),
                    fixed(number_of(pass, "peak_memory_mib"), 0),
                    pass.value("from_cache", Json(false)) == Json(true) ? "yes" : ""});
  }
  grid.push_back({"total", fixed(wall_s, 2), fixed(cpu_s, 2), "", ""});
  return html_table(grid,
                    "Time and memory of each pass in the compile that wrote this map; memory is "
                    "the peak of the whole process during the pass");
}

std::string warnings_of(const Json& passes) {
  Facts warnings;
  for (const Json& pass : passes) {
    const std::string of_pass = list_of(pass, "warnings");
    if (of_pass.empty()) continue;
    warnings.emplace_back(text_of(pass.value("name", Json(""))), of_pass);
  }
  return warnings.empty() ? "" : "<h3>Warnings</h3>\n" + fact_table(warnings);
}

std::string configuration_table(const Json& configuration) {
  TextGrid grid = {{"key", "value"}};
  for (const auto& [section, keys] : configuration.items()) {
    for (const auto& [key, value] : keys.items()) {
      grid.push_back({concat(section, ".", key), text_of(value)});
    }
  }
  return concat("<details><summary>Configuration</summary>\n",
                html_table(grid, "All keys with the values of this compile"), "</details>\n");
}

std::string model_table(const CompiledMap& map) {
  TextGrid grid = {{"property", "value"}};
  for (const auto& [name, value] : map.model.card) grid.push_back({name, value});
  return concat("<details><summary>Error model</summary>\n",
                html_table(grid, "Training data and quality of the error model"), "</details>\n");
}

Facts map_facts(const ReportSources& sources) {
  const CompiledMap& map = *sources.map;
  std::string definitions;
  for (const NamedVersion& definition : map.definitions) {
    definitions +=
        concat((definitions.empty() ? "" : ", "), definition.name, " v", definition.version);
  }
  const bool is_simulated = map.measurement.reference == ErrorReference::kSimulated;
  return {
      {"map file", sources.map_file},
      {"map", map.map_id},
      {"version", concat(map.version, ", release ", map.release)},
      {"written by", concat(map.writer, ", format ", sources.summary.format)},
      {"root digest", to_hex(sources.summary.root_digest)},
      {"model digest", to_hex(sources.summary.model_digest)},
      {is_simulated ? "finished map" : "mapping drive",
       concat(map.measurement.mapping_drive, ", ", map.measurement.mapping_scans, " scans")},
      {"localization drive", is_simulated ? "none: errors were simulated"
                                          : concat(map.measurement.localization_drive, ", ",
                                                   map.measurement.localization_scans, " scans")},
      {"localizing sensor", map.sensor.name},
      {"localizer of the predictions", to_text(map.model.localizer)},
      {"measured localizer", to_text(map.measurement.localizer)},
      {"definitions", definitions}};
}

}  // namespace

// The trajectory, how sharp the map is, and which moving objects were removed.
Section making_section(const ReportSources& sources) {
  Section section = {"making", "How the map was made", ""};
  section.html = "<h3>Trajectory</h3>\n";
  if (sources.trajectory) {
    section.html += trajectory_facts(*sources.trajectory);
    const auto is_uncertain = [](const TrajectoryPose& pose) {
      return pose.covariance(0, 0) > 0.0;
    };
    if (std::ranges::any_of(sources.trajectory->poses, is_uncertain))
      section.html += uncertainty_figure(*sources.trajectory);
  }
  if (sources.map->trajectory) {
    section.html += unconstrained_table(sources.map->trajectory->unconstrained);
  }
  section.html += notices_table(sources.map->notices);
  if (sources.map->sharpness) section.html += sharpness_table(*sources.map->sharpness);
  section.html += "<h3>Moving objects removed</h3>\n";
  section.html +=
      sources.points
          ? moving_facts(*sources.points)
          : paragraph("Unknown: the points of the drive were not available for this page.");
  return section;
}

Result<Section> passes_section(const ReportSources& sources) {
  Section section = {"passes", "Time and memory", ""};
  if (sources.provenance.empty()) {
    section.html = paragraph("Unknown: there is no provenance file beside the map.");
    return section;
  }
  SIGHTLINE_ASSIGN(const Json provenance, provenance_of(sources));
  const Json passes = provenance.value("passes", Json::array());
  section.html = pass_table(passes) + warnings_of(passes);
  return section;
}

// The map's own facts, and what the provenance file beside it holds.
Result<Section> provenance_section(const ReportSources& sources) {
  Section section = {"provenance", "Provenance", ""};
  Facts facts = map_facts(sources);
  std::string configuration;
  if (!sources.provenance.empty()) {
    SIGHTLINE_ASSIGN(const Json provenance, provenance_of(sources));
    for (const auto& [name, value] : provenance.items()) {
      if (name == "passes" || name == "configuration" || name == "inputs") continue;
      facts.emplace_back(
          name, name == "command_line" ? list_of(provenance, "command_line") : text_of(value));
    }
    const Json inputs = provenance.value("inputs", Json::object());
    for (const auto& [name, value] : inputs.items()) {
      facts.emplace_back("input " + name, text_of(value));
    }
    configuration = configuration_table(provenance.value("configuration", Json::object()));
  }
  section.html =
      concat("<details><summary>Files, versions and inputs</summary>\n", fact_table(facts),
             "</details>\n", configuration, model_table(*sources.map));
  return section;
}

}  // namespace sightline
