#include "compiler/driver/compile_config.h"

#include <algorithm>

#include "compiler/gate/settings.h"

namespace sightline {
namespace {

// Set through AnnotationOptions, so that passes cannot disagree.
const std::vector<std::string> kShared = {
    "ranges_m",      "limits_m",           "tile_m",         "longest_range_m",  "leaf_m", "scans",
    "mapping_scans", "localization_scans", "localizer_used", "coarse_cells_used",
    "support_margin_used", "extrapolated_longest_used"};

template <class Options>
ConfigSection pass_section(std::string name, std::string help, Options& options) {
  ConfigSection section{std::move(name), std::move(help), option_fields(options)};
  std::erase_if(section.fields, [](const OptionField& field) {
    return std::ranges::find(kShared, field.name) != kShared.end();
  });
  return section;
}

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

// How scans are matched is told in the section measure-error, how far a site speaks by the map.
ConfigSection track_section(TrackDriveOptions& options) {
  ConfigSection section{"track-drive", "Replaying a drive as a vehicle localizes",
                        option_fields(options)};
  std::erase_if(section.fields,
                [](const OptionField& field) { return field.name != "lost_beyond_m"; });
  return section;
}

// Copies a value into the field of that name, where the pass has one.
template <class Options>
Result<void> share(const std::string& name, const std::string& value, Options& options) {
  for (OptionField& field : option_fields(options)) {
    if (field.name != name) continue;
    const Result<void> set = set_from_text(field, value);
    if (!set) return set;
  }
  return {};
}

Result<void> share_with_all(const std::string& name, const std::string& value,
                            CompileConfig& config) {
  Result<void> result;
  const auto to = [&](auto& options) {
    if (result) result = share(name, value, options);
  };
  to(config.ingest);
  to(config.build_ndt);
  to(config.build_surface);
  to(config.cast_rays);
  to(config.cast_scans);
  to(config.compute_factors);
  to(config.measure_error);
  to(config.train_model);
  to(config.predict_error);
  to(config.choose_ranges);
  to(config.evaluate_ranges);
  to(config.emit_map);
  return result;
}

Result<void> spread_shared(CompileConfig& config) {
  for (const OptionField& field : option_fields(config.annotation)) {
    if (std::ranges::find(kShared, field.name) == kShared.end()) continue;
    const Result<void> shared = share_with_all(field.name, to_text(field), config);
    if (!shared) return shared;
  }
  const double longest_m = config.annotation.ranges_m.back();
  config.cast_rays.longest_range_m = longest_m;
  config.cast_scans.longest_range_m = longest_m;
  const std::string mapping_scans = config.is_split() ? "even" : "all";
  config.remove_moving.scans = config.choose_sites.scans = mapping_scans;
  config.measure_error.scans = config.is_split() ? "odd" : "all";
  config.emit_map.mapping_scans = mapping_scans;
  config.emit_map.localization_scans = config.measure_error.scans;
  config.emit_map.localizer_used = config.measure_error.localizer;
  config.emit_map.coarse_cells_used = config.measure_error.coarse_cells;
  config.emit_map.support_margin_used = config.predict_error.support_margin;
  config.emit_map.extrapolated_longest_used = config.choose_ranges.extrapolated_takes_longest;
  return {};
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
  if (config.annotation.split == "even-odd" && has_drive) {
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

std::vector<ConfigSection> sections(CompileConfig& config) {
  std::vector<ConfigSection> all = {
      {"annotation", "What is annotated, and what all passes share",
       option_fields(config.annotation)},
      {"mapping", "The drive that makes the map", option_fields(config.mapping)},
      {"localization", "A second drive that is matched against the map to measure error",
       option_fields(config.localization)},
      {"evaluation", "An independent drive that judges the finished map (sightline evaluate)",
       option_fields(config.evaluation)},
      pass_section("ingest", "Reading drives", config.ingest),
      pass_section("estimate-trajectory", "Where the vehicle was", config.estimate_trajectory),
      pass_section("align-drive", "A second drive in the map of the first", config.align_drive),
      pass_section("measure-sharpness", "How sharp the map is", config.measure_sharpness),
      pass_section("undistort-scans", "Motion during a scan", config.undistort_scans),
      pass_section("remove-moving", "What moved leaves the map", config.remove_moving),
      pass_section("build-ndt", "The NDT map", config.build_ndt),
      pass_section("build-surface", "The surface that rays hit", config.build_surface),
      pass_section("choose-sites", "Places to annotate", config.choose_sites),
      pass_section("cast-rays", "Depth images", config.cast_rays),
      pass_section("cast-scans", "Virtual scans", config.cast_scans),
      pass_section("compute-factors", "Map factors", config.compute_factors),
      pass_section("measure-error", "Localization error of a drive", config.measure_error),
      pass_section("train-model", "The error model", config.train_model),
      pass_section("predict-error", "What the model says of each site", config.predict_error),
      pass_section("choose-ranges", "How far to look", config.choose_ranges),
      pass_section("evaluate-ranges", "Judging the choice", config.evaluate_ranges),
      track_section(config.track_drive),
      pass_section("emit-map", "The map file", config.emit_map),
  };
  all.push_back({"gate", "What a map must hold to pass (sightline gate)", {}, gate_settings_schema()});
  for (std::size_t i = config.other_sensors.size(); i-- > 0;) {
    all.insert(all.begin() + 2, sensor_section(i, config.other_sensors[i]));
  }
  return all;
}

Result<CompileConfig> load_compile_config(const std::filesystem::path& file,
                                          const std::vector<std::string>& overrides) {
  CompileConfig config;
  std::vector<ConfigSection> all = sections(config);
  const Result<void> read = read_yaml(file, all);
  if (!read) return read.error();
  for (RecordingOptions* recording : {&config.mapping, &config.localization, &config.evaluation}) {
    resolve(file.parent_path(), *recording);
  }
  for (RecordingOptions& sensor : config.other_sensors) resolve(file.parent_path(), sensor);
  for (const std::string& assignment : overrides) {
    const Result<void> set = set_override(assignment, all);
    if (!set) return set.error();
  }
  const Result<void> checked = check(config, file);
  if (!checked) return checked.error();
  // Judged later, but a mistake in it is told before hours of work.
  const Result<GateSettings> gate = read_gate_settings(file);
  if (!gate) return gate.error();
  const Result<void> spread = spread_shared(config);
  if (!spread) return spread.error();
  return config;
}

}  // namespace sightline
