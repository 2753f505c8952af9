#include "compiler/config/compile_config.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>

#include "compiler/config/recordings.h"
#include "compiler/gate/settings.h"
#include "formats/annotation/measured_drives.h"
#include "formats/base/files/regular_file.h"
#include "formats/foreign/maps/apollo_map.h"
#include "formats/foreign/text/sensor_file.h"
#include "formats/foreign/text/text_lines.h"
#include "formats/geodesy.h"
#include "formats/reader/map_layout.h"
#include "formats/text/table.h"
#include "passes/ingest/ingest.h"
#include "passes/localize/measure_error.h"
#include "passes/localize/pcl/pcl_ndt.h"

namespace sightline {
namespace {

Error bad_value(const std::string& message) { return {ErrorCode::kBadValue, message}; }

// Before hours of work.
Result<void> check_map(const CompileConfig& config) {
  if (!config.mapping.scans.empty()) {
    return bad_value(
        "mapping.scans and map.points are both given; use mapping.scans to make a map, or "
        "map.points to annotate a finished one");
  }
  if (!config.base_poses.empty()) {
    return bad_value(
        "base.poses and map.points are both given; base.poses applies only to maps made from "
        "drives: remove one of them");
  }
  if (config.route.file.empty()) {
    return Error{ErrorCode::kMissingKey,
                 "route.file is missing: a finished map is annotated along a route"};
  }
  const Result<World> world = parse_world(config.route.world);
  if (!world) return bad_value("route.world: " + world.error().message);
  const bool is_own = config.passes.options(kMeasureError).localizer != LocalizerKind::kPclNdt &&
                      !config.imports_errors();
  if (config.localization.scans.empty() && !is_own) {
    return bad_value(
        "without a localization drive, errors are simulated with this program's own localizers; "
        "add a localization drive, or remove import-errors and measure-error.localizer");
  }
  if (config.annotation.split == Split::kEvenOdd) {
    return bad_value("annotation.split is even-odd, which needs a mapping drive; remove it");
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

// `folder` is that of the configuration.
void resolve(const std::filesystem::path& folder, std::string& path) {
  if (!path.empty()) path = (folder / path).lexically_normal().string();
}

// `are_several`: poses and stamps are names of files that lie with each (recordings.h).
void resolve(const std::filesystem::path& folder, bool are_several, RecordingOptions& recording) {
  resolve(folder, recording.scans);
  resolve(folder, recording.calibration);
  if (!are_several) {
    resolve(folder, recording.poses);
    resolve(folder, recording.stamps);
  }
  if (is_sensor_file(recording.sensor)) resolve(folder, recording.sensor);
}

void resolve_all(const std::filesystem::path& folder, CompileConfig& config) {
  visit_recordings(config, [&](const RecordingRole& role, RecordingOptions& recording) {
    const bool is_list =
        (role.use == RecordingUse::kMapping && !config.mapping_recordings.empty()) ||
        (role.use == RecordingUse::kLocalization && !config.localization_recordings.empty());
    resolve(folder, is_list && !role.is_later(), recording);
  });
  for (std::string* path :
       {&config.outside.file, &config.outside.evaluation_file, &config.map.points,
        &config.base_poses, &config.mapping_recordings, &config.localization_recordings}) {
    resolve(folder, *path);
  }
  if (!config.route.is_everywhere()) resolve(folder, config.route.file);
}

// A finished map has one coordinate system, whichever key names it.
Result<void> settle_world(CompileConfig& config) {
  std::string& of_map = config.annotation.world;
  std::string& of_route = config.route.world;
  if (!config.has_map() || of_map == of_route) return {};
  if (of_map != kLocalWorld && of_route != kLocalWorld) {
    return bad_value(concat("annotation.world is ", of_map, ", but route.world (--world) is ",
                            of_route, "; name one coordinate system, that of the map"));
  }
  (of_map == kLocalWorld ? of_map : of_route) = of_map == kLocalWorld ? of_route : of_map;
  return {};
}

Result<void> expand_all(CompileConfig& config) {
  SIGHTLINE_TRY(expand_recordings("mapping", config.mapping_recordings, config.mapping,
                                  config.later_mapping));
  return expand_recordings("localization", config.localization_recordings, config.localization,
                           config.later_localization);
}

// A drive that names no sensor has the one of `from`: beams, height and mounting too, as far as it
// has none of its own.
void inherit_sensor(const RecordingOptions& from, RecordingOptions& to) {
  to.sensor = from.sensor.empty() ? RecordingOptions().sensor : from.sensor;
  if (to.rings == 0) {
    to.rings = from.rings;
    to.lowest_beam_deg = from.lowest_beam_deg;
    to.highest_beam_deg = from.highest_beam_deg;
  }
  if (to.azimuth_view_deg == 0.0) to.azimuth_view_deg = from.azimuth_view_deg;
  if (to.height_m == 0.0) to.height_m = from.height_m;
  constexpr std::array<double RecordingOptions::*, 6> kMounting = {
      &RecordingOptions::lidar_x_m,       &RecordingOptions::lidar_y_m,
      &RecordingOptions::lidar_z_m,       &RecordingOptions::lidar_roll_deg,
      &RecordingOptions::lidar_pitch_deg, &RecordingOptions::lidar_yaw_deg};
  const bool is_mounted = std::ranges::any_of(
      kMounting, [&](double RecordingOptions::*value) { return to.*value != 0.0; });
  if (is_mounted) return;
  for (double RecordingOptions::*value : kMounting) to.*value = from.*value;
}

void inherit_sensors(CompileConfig& config) {
  visit_recordings(config, [&](const RecordingRole& /*role*/, RecordingOptions& recording) {
    if (recording.scans.empty() || !recording.sensor.empty()) return;
    inherit_sensor(config.has_map() ? config.map.localizing : config.mapping, recording);
  });
}

// Drives of lists.
Result<void> check_lists(const CompileConfig& config) {
  std::string missing;
  const bool is_list = !config.later_localization.empty();
  visit_recordings(config, [&](const RecordingRole& role, const RecordingOptions& recording) {
    const bool is_listed = role.is_later() || (is_list && role.use == RecordingUse::kLocalization);
    if (is_listed && recording.scans.empty() && missing.empty()) missing = to_text(role);
  });
  if (!missing.empty()) {
    return Error{ErrorCode::kMissingKey,
                 missing + ".scans is missing: name a folder or file of scans"};
  }
  if (!is_list || !config.imports_errors()) return {};
  return bad_value(concat("import-errors.file has the errors of one localization drive, and ",
                          1 + config.later_localization.size(), " are listed; keep one"));
}

Result<void> check(const CompileConfig& config) {
  if (config.has_map()) {
    SIGHTLINE_TRY(check_map(config));
  } else if (config.mapping.scans.empty()) {
    return Error{ErrorCode::kMissingKey,
                 "mapping.scans is missing: name a folder or file of scans (or a finished map "
                 "under map.points); `sightline init FOLDER -o drive.yaml` writes a configuration"};
  }
  SIGHTLINE_TRY(check_lists(config));
  const Result<World> world = parse_world(config.annotation.world);
  if (!world) return bad_value("annotation." + world.error().message);
  if (config.imports_errors() || config.imports_evaluation()) {
    SIGHTLINE_TRY(outside_localizer(config.outside));
  }
  const bool wants_pcl = config.passes.options(kMeasureError).localizer == LocalizerKind::kPclNdt;
  if (wants_pcl && !has_pcl_ndt()) {
    return bad_value(
        "measure-error.localizer is pcl-ndt, but this program was built without PCL; "
        "tests/support/setup installs its package libpcl-dev and builds the program with it");
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
    return bad_value(concat("import-errors.parameters: found '", options.parameters,
                            "', expected \"name=value, ...\", each name once"));
  }
  for (const std::string& own : localizer_names()) {
    if (options.localizer != own) continue;
    return bad_value(concat("import-errors.localizer: ", own,
                            " is a localizer of this program, set by measure-error.localizer; give "
                            "yours another name"));
  }
  LocalizerProfile profile{options.localizer, static_cast<std::uint32_t>(options.version),
                           *parameters};
  if (validate(profile)) return profile;
  return bad_value(
      "import-errors.localizer: expected the name that the vehicle's program uses, 1 to 64 "
      "printable characters without blanks or '/'");
}

bool is_compiled_map(const std::filesystem::path& path) {
  const Result<std::string> beginning = read_beginning(path.string(), kMapBeginning.size());
  return beginning && *beginning == kMapBeginning;
}

Result<void> read_compile_config(const std::filesystem::path& file,
                                 const std::vector<std::string>& overrides,
                                 std::vector<ConfigSection> sections, CompileConfig& config) {
  const bool has_file = !file.empty();
  if (has_file) {
    SIGHTLINE_TRY(read_yaml(file, sections));
  }
  resolve_all(file.parent_path(), config);
  for (const std::string& assignment : overrides) {
    SIGHTLINE_TRY(set_override(assignment, sections));
  }
  const Result<void> expanded = expand_all(config);
  if (!expanded) return in_file(expanded.error(), file.string());
  inherit_sensors(config);
  const Result<void> settled = settle_world(config);
  if (!settled) return in_file(settled.error(), file.string());
  visit_recordings(config, [&](const RecordingRole& role, RecordingOptions& recording) {
    if (role.use != RecordingUse::kOtherSensor) recording.world = config.annotation.world;
  });
  config.map.is_apollo = config.has_map() && is_apollo_map(config.map.points);
  config.map.is_compiled = config.has_map() && is_compiled_map(config.map.points);
  config.passes = settings_of(sections);
  config.passes.shared = shared_values(config.annotation);
  const Result<void> checked = check(config);
  if (!checked) return in_file(checked.error(), file.string());
  // Used later, but a mistake in it is reported before hours of work.
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
  visit_recordings(config, [&](const RecordingRole& role, RecordingOptions& recording) {
    if (!role.is_later()) return;
    for (const OptionField& field : option_fields(recording)) {
      values.push_back({to_text(role), field.name, to_text(field)});
    }
  });
  for (const auto& [section, fields] : config.passes.own) {
    for (const auto& [key, value] : fields) values.push_back({section, key, value});
  }
  return values;
}

}  // namespace sightline
