#include "compiler/config/compile_config.h"

#include <algorithm>
#include <map>
#include <optional>

#include "compiler/gate/settings.h"
#include "formats/annotation/measured_drives.h"
#include "formats/foreign/maps/apollo_map.h"
#include "formats/foreign/text/sensor_file.h"
#include "formats/foreign/text/text_lines.h"
#include "formats/geodesy.h"
#include "formats/text/table.h"
#include "passes/ingest/ingest.h"
#include "passes/localize/measure_error.h"
#include "passes/localize/pcl/pcl_ndt.h"

namespace sightline {
namespace {

// Another sensor of the mapping drive: the keys of a drive but for those of its poses.
ConfigSection sensor_section(std::size_t index, RecordingOptions& options) {
  ConfigSection section{other_sensor_section(index),
                        "Another sensor on the vehicle of the mapping drive, in the same frame and "
                        "on the same clock",
                        option_fields(options)};
  std::erase_if(section.fields, [](const OptionField& field) {
    return field.name.starts_with("pose") || field.name == "name";
  });
  return section;
}

// A section of one drive, or of a list of them. What tells drives of one vehicle apart is each
// one's own, the rest is as in the first unless it is said.
ConfigSection drives_section(const std::string& name, const std::string& help,
                             RecordingOptions& first, std::deque<RecordingOptions>& more) {
  ConfigSection section{name, help, option_fields(first)};
  section.one_more = [&first, &more] {
    RecordingOptions& later = more.emplace_back(first);
    for (std::string* own : {&later.name, &later.scans, &later.poses, &later.stamps}) own->clear();
    return option_fields(later);
  };
  return section;
}

ConfigSection mapping_section(CompileConfig& config) {
  return drives_section("mapping",
                        "The drive that makes the map; or a list of drives of one vehicle, in the "
                        "order of their days, each with what differs from the first",
                        config.mapping, config.later_mapping);
}

ConfigSection localization_section(CompileConfig& config) {
  return drives_section("localization",
                        "A second drive that is matched against the map to measure error; or a "
                        "list of drives, each measured by itself: the first has to come near the "
                        "map, the others say what differs from it",
                        config.localization, config.later_localization);
}

// A finished map: the keys of a drive that tell of its sensor.
std::vector<OptionField> option_fields(MapOptions& options) {
  std::vector<OptionField> fields = {
      text("points", options.points,
           "a finished map in place of the mapping drive: .pcd, .ply or .las, a folder of them, "
           "Autoware's with pointcloud_map_metadata.yaml, Apollo's NDT map (config.xml and map/), "
           "or a compiled map (.slmap) to annotate anew; empty: the drive makes the map"),
      text("name", options.name, "name of the map; empty: the last part of points")};
  for (OptionField& field : option_fields(options.localizing)) {
    const bool tells_of_sensor = field.name == "sensor" || field.name == "rings" ||
                                 field.name == "height_m" || field.name.ends_with("_beam_deg") ||
                                 field.name.starts_with("lidar_");
    if (!tells_of_sensor) continue;
    if (field.name == "sensor") {
      field.help =
          "the LiDAR that will localize, as under mapping; empty: that of a compiled map, "
          "else generic-16";
    }
    fields.push_back(std::move(field));
  }
  return fields;
}

std::vector<OptionField> option_fields(RouteOptions& options) {
  return {text("file", options.file,
               "where a finished map is annotated: Lanelet2 (.osm), .geojson, .csv of x, y and z, "
               "a trajectory (.tum), or everywhere that a vehicle reaches (everywhere; section "
               "choose-field-sites)"),
          text("world", options.world,
               "how the map lies on Earth, for lanes in latitude and longitude: local, utm:32N or "
               "enu:LATITUDE,LONGITUDE,ALTITUDE; local: as a compiled map says")};
}

// Before hours of work.
Result<void> check_map(const CompileConfig& config, const std::filesystem::path& file) {
  const auto bad = [&](ErrorCode code, const std::string& message) {
    return Error{code, message, file.string(), ""};
  };
  if (!config.mapping.scans.empty()) {
    return bad(ErrorCode::kBadValue,
               "mapping.scans and map.points are named: either a drive makes the map, or it is "
               "finished");
  }
  if (!config.base_poses.empty()) {
    return bad(ErrorCode::kBadValue,
               "base.poses and map.points are named: a finished map has no drives that could keep "
               "their poses");
  }
  if (config.route.file.empty()) {
    return bad(ErrorCode::kMissingKey, "route.file: a finished map is annotated along a route");
  }
  const Result<World> world = parse_world(config.route.world);
  if (!world) return bad(ErrorCode::kBadValue, "route.world: " + world.error().message);
  const bool is_own = config.passes.options(kMeasureError).localizer != LocalizerKind::kPclNdt &&
                      !config.imports_errors();
  if (config.localization.scans.empty() && !is_own) {
    return bad(ErrorCode::kBadValue,
               "without a localization drive errors are simulated, for this program's own "
               "localizers alone: name a drive, or leave measure-error.localizer and import-errors "
               "as they are");
  }
  if (config.annotation.split == Split::kEvenOdd) {
    return bad(ErrorCode::kBadValue, "annotation.split is even-odd and no drive makes the map");
  }
  return {};
}

// What all passes share, from the section annotation.
std::map<std::string, std::string> shared_values(AnnotationOptions annotation) {
  std::map<std::string, std::string> values;
  for (const OptionField& field : option_fields(annotation)) values[field.name] = to_text(field);
  values["every_return"] = annotation.looks.empty() ? "true" : "false";
  values["longest_range_m"] = format_double(annotation.ranges_m.back());
  return values;
}

void resolve(const std::filesystem::path& folder, RecordingOptions& recording) {
  for (std::string* path :
       {&recording.scans, &recording.poses, &recording.stamps, &recording.calibration}) {
    if (!path->empty()) *path = (folder / *path).lexically_normal().string();
  }
  if (is_sensor_file(recording.sensor)) {
    recording.sensor = (folder / recording.sensor).lexically_normal().string();
  }
}

// The drives of the list under `localization`.
Result<void> check_localization(const CompileConfig& config, const std::filesystem::path& file) {
  if (config.later_localization.empty()) return {};
  std::map<std::string, std::string> role_of_scans;
  for (std::size_t i = 0; i <= config.later_localization.size(); ++i) {
    const RecordingOptions& drive = i == 0 ? config.localization : config.later_localization[i - 1];
    const std::string role = localization_role(i);
    if (drive.scans.empty()) {
      return Error{ErrorCode::kMissingKey, role + ".scans: no folder of scans is named",
                   file.string(), ""};
    }
    const auto [other, is_new] = role_of_scans.try_emplace(drive.scans, role);
    if (is_new) continue;
    return Error{ErrorCode::kBadValue,
                 role + ".scans: found the recording of " + other->second +
                     ", expected another drive: one drive told twice is no second witness",
                 file.string(), ""};
  }
  if (!config.imports_errors()) return {};
  return Error{ErrorCode::kBadValue,
               "import-errors.file is of one localization drive, and " +
                   std::to_string(1 + config.later_localization.size()) + " are named",
               file.string(), ""};
}

Result<void> check(const CompileConfig& config, const std::filesystem::path& file) {
  if (config.has_map()) {
    SIGHTLINE_TRY(check_map(config, file));
  } else if (config.mapping.scans.empty()) {
    return Error{
        ErrorCode::kMissingKey,
        "mapping.scans: no folder of scans is named (map.points takes a finished map); `sightline "
        "init FOLDER -o drive.yaml` writes a configuration",
        file.string(), ""};
  }
  for (std::size_t i = 0; i < config.later_mapping.size(); ++i) {
    if (!config.later_mapping[i].scans.empty()) continue;
    return Error{ErrorCode::kMissingKey,
                 later_mapping_role(i) + ".scans: no folder of scans is named", file.string(), ""};
  }
  SIGHTLINE_TRY(check_localization(config, file));
  const Result<World> world = parse_world(config.annotation.world);
  if (!world) {
    return Error{ErrorCode::kBadValue, "annotation." + world.error().message, file.string(), ""};
  }
  const bool has_drive = !config.localization.scans.empty();
  if (config.annotation.split == Split::kEvenOdd && has_drive) {
    return Error{ErrorCode::kBadValue,
                 "annotation.split is even-odd and a localization drive is named: choose one",
                 file.string(), ""};
  }
  if (config.imports_errors() || config.imports_evaluation()) {
    const Result<LocalizerProfile> localizer = outside_localizer(config.outside);
    if (!localizer) return in_file(localizer.error(), file.string());
  }
  const bool wants_pcl = config.passes.options(kMeasureError).localizer == LocalizerKind::kPclNdt;
  if (wants_pcl && !has_pcl_ndt()) {
    return Error{ErrorCode::kBadValue,
                 "measure-error.localizer is pcl-ndt, and this program was built without PCL",
                 file.string(), ""};
  }
  return {};
}

// "a=1, b = 2" as pairs, ascending by name. Nothing where it is not of that form.
std::optional<std::vector<std::pair<std::string, std::string>>> pairs_of(const std::string& text) {
  std::map<std::string, std::string> pairs;
  std::vector<std::string_view> words;
  split_words(text, words, ",");
  for (const std::string_view word : words) {
    std::vector<std::string_view> sides;
    split_words(word, sides, " =");
    const bool is_pair = sides.size() == 2 && std::ranges::count(word, '=') == 1;
    if (!is_pair || !pairs.emplace(sides[0], sides[1]).second) return std::nullopt;
  }
  return std::vector<std::pair<std::string, std::string>>(pairs.begin(), pairs.end());
}

}  // namespace

Result<LocalizerProfile> outside_localizer(const OutsideErrorsOptions& options) {
  const auto parameters = pairs_of(options.parameters);
  if (!parameters) {
    return Error{ErrorCode::kBadValue,
                 "import-errors.parameters: found '" + options.parameters +
                     "', expected \"name=value, ...\", each name once",
                 "", ""};
  }
  for (const std::string& own : localizer_names()) {
    if (options.localizer != own) continue;
    return Error{ErrorCode::kBadValue,
                 "import-errors.localizer: " + own +
                     " is one of this program's own, which measures "
                     "its errors itself (measure-error.localizer); name yours otherwise",
                 "", ""};
  }
  LocalizerProfile profile{options.localizer, static_cast<std::uint32_t>(options.version),
                           *parameters};
  if (validate(profile)) return profile;
  return Error{ErrorCode::kBadValue,
               "import-errors.localizer: expected the name by which the vehicle's program will "
               "know it, 1 to 64 printable characters without a blank or '/'",
               "", ""};
}

std::vector<OptionField> option_fields(OutsideErrorsOptions& options) {
  return {
      text("file", options.file,
           "CSV with a line \"scan,look,start,error\" and one error a line: what a localizer of "
           "yours made of the localization drive, in place of measure-error; empty: none"),
      text("evaluation_file", options.evaluation_file, "the same of the evaluation drive"),
      text("localizer", options.localizer,
           "its name, which the map keeps and the vehicle tells the reader"),
      integer("version", options.version, "raise it when that localizer changes", 0, 1'000'000'000),
      text("parameters", options.parameters,
           "what the name leaves open, for the record: \"name=value, ...\""),
      choice("reference", options.reference,
             "what the errors were measured against: the known pose, or the match at full range",
             {"known", "full-range"})};
}

std::vector<OptionField> option_fields(AnnotationOptions& options) {
  return {numbers("ranges_m", options.ranges_m, "observation ranges to choose from, m", 1.0, 300.0),
          looks("looks", options.looks,
                "looks to choose from, each a range and the sample of a scan that is matched, from "
                "the cheapest to the dearest; paper: observation ranges alone, every return within "
                "them"),
          numbers("limits_m", options.limits_m, "localization errors a vehicle may accept, m", 0.01,
                  5.0),
          number("leaf_m", options.leaf_m, "voxel grid a scan is subsampled on to be matched, m",
                 0.05, 10.0),
          number("tile_m", options.tile_m, "edge of a map tile, m; a multiple of the cell", 8.0,
                 1024.0),
          integer("seed", options.seed, "seed of everything random", 0, 1'000'000'000),
          text("world", options.world,
               "where the recordings' coordinates lie, which the map carries: local, utm:ZONE "
               "(utm:32N), mgrs:SQUARE (mgrs:32UMV) or enu:LATITUDE,LONGITUDE,ALTITUDE"),
          choice("split", options.split,
                 "even-odd: even scans of the mapping drive map, odd ones localize; auto: so where "
                 "no localization drive is named",
                 {"auto", "even-odd"})};
}

std::string other_sensor_section(std::size_t index) {
  return "mapping-" + std::to_string(index + 2);
}

std::string later_mapping_role(std::size_t index) {
  return "mapping[" + std::to_string(index + 2) + "]";
}

std::string later_localization_role(std::size_t index) { return localization_role(index + 1); }

std::vector<ConfigSection> drive_sections(CompileConfig& config) {
  std::vector<ConfigSection> all = {
      {"annotation", "What is annotated, and what all passes share",
       option_fields(config.annotation)},
      mapping_section(config),
      {.name = "base",
       .help = "What was shipped, for a map with more drives; or the file alone",
       .fields = {text("poses", config.base_poses,
                       "poses that were written beside an earlier map (.slposes): its drives, "
                       "named first under mapping, keep them; empty: poses are found anew")},
       .word = "poses"},
      {.name = "map",
       .help = "A finished map, annotated along `route`, in place of `mapping`; or its file alone",
       .fields = option_fields(config.map),
       .word = "points"},
      {.name = "route",
       .help = "Where a finished map is annotated; or the file alone, or `everywhere`",
       .fields = option_fields(config.route),
       .word = "file"}};
  for (std::size_t i = 0; i < config.other_sensors.size(); ++i) {
    all.push_back(sensor_section(i, config.other_sensors[i]));
  }
  all.push_back(localization_section(config));
  all.push_back({"evaluation",
                 "An independent drive that judges the finished map (sightline evaluate)",
                 option_fields(config.evaluation)});
  all.push_back({"import-errors", "Errors that a localizer of yours made, measured outside",
                 option_fields(config.outside)});
  return all;
}

ConfigSection gate_section() {
  return {"gate", "What a map must hold to pass (sightline gate)", {}, gate_settings_schema()};
}

Result<void> read_compile_config(const std::filesystem::path& file,
                                 const std::vector<std::string>& overrides,
                                 std::vector<ConfigSection> sections, CompileConfig& config) {
  const bool has_file = !file.empty();
  if (has_file) {
    SIGHTLINE_TRY(read_yaml(file, sections));
  }
  for (RecordingOptions* recording : {&config.mapping, &config.localization, &config.evaluation}) {
    resolve(file.parent_path(), *recording);
  }
  for (RecordingOptions& sensor : config.other_sensors) resolve(file.parent_path(), sensor);
  for (RecordingOptions& later : config.later_mapping) resolve(file.parent_path(), later);
  for (RecordingOptions& later : config.later_localization) resolve(file.parent_path(), later);
  for (std::string* path : {&config.outside.file, &config.outside.evaluation_file,
                            &config.map.points, &config.route.file, &config.base_poses}) {
    if (path == &config.route.file && config.route.is_everywhere()) continue;
    if (!path->empty()) *path = (file.parent_path() / *path).lexically_normal().string();
  }
  for (const std::string& assignment : overrides) {
    SIGHTLINE_TRY(set_override(assignment, sections));
  }
  for (RecordingOptions* recording : {&config.mapping, &config.localization, &config.evaluation}) {
    recording->world = config.annotation.world;
  }
  for (RecordingOptions& later : config.later_mapping) later.world = config.annotation.world;
  for (RecordingOptions& later : config.later_localization) later.world = config.annotation.world;
  config.map.is_apollo = config.has_map() && is_apollo_map(config.map.points);
  config.passes = settings_of(sections);
  config.passes.shared = shared_values(config.annotation);
  SIGHTLINE_TRY(check(config, file));
  // Judged later, but a mistake in it is reported before hours of work.
  if (has_file) {
    SIGHTLINE_TRY(read_gate_settings(file));
  }
  return {};
}

std::vector<EffectiveValue> effective_values(CompileConfig config) {
  std::vector<EffectiveValue> values;
  for (const ConfigSection& section : drive_sections(config)) {
    for (const OptionField& field : section.fields) {
      values.push_back({section.name, field.name, to_text(field)});
    }
  }
  for (std::size_t i = 0; i < config.later_mapping.size(); ++i) {
    for (const OptionField& field : option_fields(config.later_mapping[i])) {
      values.push_back({later_mapping_role(i), field.name, to_text(field)});
    }
  }
  for (std::size_t i = 0; i < config.later_localization.size(); ++i) {
    for (const OptionField& field : option_fields(config.later_localization[i])) {
      values.push_back({later_localization_role(i), field.name, to_text(field)});
    }
  }
  for (const auto& [section, fields] : config.passes.own) {
    for (const auto& [key, value] : fields) values.push_back({section, key, value});
  }
  return values;
}

}  // namespace sightline
