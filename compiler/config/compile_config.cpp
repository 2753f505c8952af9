#include "compiler/config/compile_config.h"

#include <algorithm>

#include "compiler/gate/settings.h"
#include "formats/text/table.h"
#include "passes/ingest/ingest.h"

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

// What all passes share, from the section annotation.
std::map<std::string, std::string> shared_values(AnnotationOptions annotation) {
  std::map<std::string, std::string> values;
  for (const OptionField& field : option_fields(annotation)) values[field.name] = to_text(field);
  values["longest_range_m"] = format_double(annotation.ranges_m.back());
  return values;
}

void resolve(const std::filesystem::path& folder, RecordingOptions& recording) {
  for (std::string* path : {&recording.scans, &recording.poses, &recording.stamps}) {
    if (!path->empty()) *path = (folder / *path).lexically_normal().string();
  }
}

Result<void> check(const CompileConfig& config, const std::filesystem::path& file) {
  if (config.mapping.scans.empty()) {
    return Error{ErrorCode::kMissingKey, "mapping.scans: no folder of scans is named",
                 file.string(), ""};
  }
  const bool has_drive = !config.localization.scans.empty();
  if (config.annotation.split == Split::kEvenOdd && has_drive) {
    return Error{ErrorCode::kBadValue,
                 "annotation.split is even-odd and a localization drive is named: choose one",
                 file.string(), ""};
  }
  return {};
}

}  // namespace

std::vector<OptionField> option_fields(AnnotationOptions& options) {
  return {numbers("ranges_m", options.ranges_m, "observation ranges to choose from, m", 1.0, 300.0),
          numbers("limits_m", options.limits_m, "localization errors a vehicle may accept, m", 0.01,
                  5.0),
          number("leaf_m", options.leaf_m, "voxel grid a scan is subsampled on to be matched, m",
                 0.05, 10.0),
          number("tile_m", options.tile_m, "edge of a map tile, m; a multiple of the cell", 8.0,
                 1024.0),
          integer("seed", options.seed, "seed of everything random", 0, 1'000'000'000),
          choice("split", options.split,
                 "even-odd: even scans of the mapping drive map, odd ones localize; auto: so where "
                 "no localization drive is named",
                 {"auto", "even-odd"})};
}

std::string other_sensor_section(std::size_t index) {
  return "mapping-" + std::to_string(index + 2);
}

std::vector<ConfigSection> drive_sections(CompileConfig& config) {
  std::vector<ConfigSection> all = {
      {"annotation", "What is annotated, and what all passes share",
       option_fields(config.annotation)},
      {"mapping", "The drive that makes the map", option_fields(config.mapping)}};
  for (std::size_t i = 0; i < config.other_sensors.size(); ++i) {
    all.push_back(sensor_section(i, config.other_sensors[i]));
  }
  all.push_back({"localization", "A second drive that is matched against the map to measure error",
                 option_fields(config.localization)});
  all.push_back({"evaluation",
                 "An independent drive that judges the finished map (sightline evaluate)",
                 option_fields(config.evaluation)});
  return all;
}

ConfigSection gate_section() {
  return {"gate", "What a map must hold to pass (sightline gate)", {}, gate_settings_schema()};
}

Result<void> read_compile_config(const std::filesystem::path& file,
                                 const std::vector<std::string>& overrides,
                                 std::vector<ConfigSection> sections, CompileConfig& config) {
  SIGHTLINE_TRY(read_yaml(file, sections));
  for (RecordingOptions* recording : {&config.mapping, &config.localization, &config.evaluation}) {
    resolve(file.parent_path(), *recording);
  }
  for (RecordingOptions& sensor : config.other_sensors) resolve(file.parent_path(), sensor);
  for (const std::string& assignment : overrides) {
    SIGHTLINE_TRY(set_override(assignment, sections));
  }
  SIGHTLINE_TRY(check(config, file));
  // Judged later, but a mistake in it is reported before hours of work.
  SIGHTLINE_TRY(read_gate_settings(file));
  config.passes = settings_of(sections);
  config.passes.shared = shared_values(config.annotation);
  return {};
}

std::vector<EffectiveValue> effective_values(CompileConfig config) {
  std::vector<EffectiveValue> values;
  for (const ConfigSection& section : drive_sections(config)) {
    for (const OptionField& field : section.fields) {
      values.push_back({section.name, field.name, to_text(field)});
    }
  }
  for (const auto& [section, fields] : config.passes.own) {
    for (const auto& [key, value] : fields) values.push_back({section, key, value});
  }
  return values;
}

}  // namespace sightline
