#pragma once

#include <array>
#include <deque>
#include <filesystem>
#include <string>
#include <vector>

#include "compiler/config/config_file.h"
#include "compiler/pipeline/plan.h"
#include "formats/annotation/measured_error.h"
#include "formats/foreign/recording/recording.h"
#include "passes/pass/default_looks.h"

namespace sightline {

enum class Split { kAuto, kEvenOdd };

// Where the error model is from if none is given: trained on this compile's own drives, or on
// generated worlds (it comes with the program).
enum class DefaultModel { kOwn, kGenerated };

// What several passes must agree on; each of them takes it from here.
struct AnnotationOptions {
  std::vector<double> ranges_m = default_ranges_m();
  std::vector<Look> looks = default_looks();
  std::vector<double> limits_m = {0.10, 0.25};
  double leaf_m = 1.0;
  double tile_m = 64.0;
  int seed = 1;
  // Where the recordings' coordinates lie (formats/geodesy.h, parse_world).
  std::string world = "local";
  // even-odd: one recording is both drives; even scans map, odd scans localize. auto: even-odd
  // where no localization drive is named, or the mapping drive again.
  Split split = Split::kAuto;
  DefaultModel model = DefaultModel::kGenerated;
};
std::vector<OptionField> option_fields(AnnotationOptions& options);

// Errors that a localizer outside of this program made, in place of what measure-error measures.
struct OutsideErrorsOptions {
  std::string file;             // CSV of the localization drive; empty: nothing is imported
  std::string evaluation_file;  // CSV of the evaluation drive
  std::string localizer;        // as the vehicle names it to the reader
  int version = 1;              // raised with each change of that localizer
  std::string parameters;       // "name=value, ...", kept in the map
  ErrorReference reference = ErrorReference::kKnownPose;
};
std::vector<OptionField> option_fields(OutsideErrorsOptions& options);

// A finished map in place of a mapping drive.
struct MapOptions {
  // Points: file, folder, or Autoware's map folder. Or NDs: Apollo's NDT map, or a compiled map, to
  // be annotated anew. Empty: a drive makes the map.
  std::string points;
  // By the contents of its files; found when the configuration is read.
  bool is_apollo = false;
  bool is_compiled = false;
  std::string name;  // empty: the last part of `points`
  // Of it the sensor alone, where no localization drive has one; no name: that of the compiled map,
  // else the usual one.
  RecordingOptions localizing;

  MapOptions() { localizing.sensor.clear(); }
};

// Where that map is annotated.
struct RouteOptions {
  // Lanes, lines or a trajectory (formats/foreign/lanes/read_route.h), or kEverywhere.
  std::string file;
  // The coordinate system of the map, for lanes in latitude and longitude; local: that of
  // annotation.world or of a compiled map. read_compile_config makes both keys equal.
  std::string world = "local";

  static constexpr const char* kEverywhere = "everywhere";
  [[nodiscard]] bool is_everywhere() const { return file == kEverywhere; }
};

// One YAML file: everything a compile and its evaluation depend on.
struct CompileConfig {
  AnnotationOptions annotation;
  RecordingOptions mapping;
  // More drives that make the map, in the order of their days. A deque: sections point into it.
  std::deque<RecordingOptions> later_mapping;
  // In their place a folder of recordings, or a file that lists them (recordings.h).
  std::string mapping_recordings;
  // Where the scans of these drives were in a map that was shipped (.slposes): they stay there.
  // Empty: all poses are found anew.
  std::string base_poses;
  // What else on the vehicle scanned during the mapping drive; no scans: there is none.
  std::array<RecordingOptions, 3> other_sensors;
  MapOptions map;      // with `route`, in place of the mapping drive
  RouteOptions route;  // where `map` is annotated
  // No scans: see AnnotationOptions::split. No sensor, here and below: that of the mapping drive,
  // else of `map`, where read_compile_config finds it.
  RecordingOptions localization;
  // More drives that are localized in the map, each by itself.
  std::deque<RecordingOptions> later_localization;
  std::string localization_recordings;  // as mapping_recordings
  RecordingOptions evaluation;          // an independent drive, for `evaluate`
  OutsideErrorsOptions outside;         // section import-errors
  PassSettings passes;                  // options of passes, with what they share
  // What was changed or may be meant otherwise, for the user; a run prints them as warnings.
  std::vector<std::string> notes;

  CompileConfig() { localization.sensor = evaluation.sensor = ""; }

  [[nodiscard]] bool has_map() const { return !map.points.empty(); }
  [[nodiscard]] bool is_split() const { return localization.scans.empty() && !has_map(); }
  [[nodiscard]] bool imports_errors() const { return !outside.file.empty(); }
  [[nodiscard]] bool imports_evaluation() const { return !outside.evaluation_file.empty(); }
};

// What a recording of a configuration is for.
enum class RecordingUse { kMapping, kOtherSensor, kLocalization, kEvaluation };

struct RecordingRole {
  RecordingUse use = RecordingUse::kMapping;
  std::size_t number = 0;  // among those of the same use
  // One more of a section's list, which is no section of its own.
  [[nodiscard]] bool is_later() const { return number > 0 && use != RecordingUse::kOtherSensor; }
};

// In messages and maps, and where it is one the section: "mapping", then "mapping[2]", ...;
// "mapping-2", "mapping-3", ... of other sensors; "localization", "localization[2]", ...;
// "evaluation".
std::string to_text(const RecordingRole& role);

// Calls visit(RecordingRole, RecordingOptions&) for every recording that a configuration has room
// for, in the order of their uses and numbers; those without `scans` are not named.
template <class Config, class Visit>
void visit_recordings(Config& config, const Visit& visit) {
  const auto visit_all = [&](RecordingUse use, std::size_t number, auto& all) {
    for (auto& recording : all) visit(RecordingRole{use, number++}, recording);
  };
  visit(RecordingRole{RecordingUse::kMapping}, config.mapping);
  visit_all(RecordingUse::kMapping, 1, config.later_mapping);
  visit_all(RecordingUse::kOtherSensor, 0, config.other_sensors);
  visit(RecordingRole{RecordingUse::kLocalization}, config.localization);
  visit_all(RecordingUse::kLocalization, 1, config.later_localization);
  visit(RecordingRole{RecordingUse::kEvaluation}, config.evaluation);
}

// The sections of the file that speak of drives and of what passes share, in its order.
std::vector<ConfigSection> drive_sections(CompileConfig& config);
// What `sightline gate` reads of the same file.
ConfigSection gate_section();

// The localizer of import-errors. Error: bad-value.
Result<LocalizerProfile> outside_localizer(const OutsideErrorsOptions& options);

// Whether there is a compiled map, by its first bytes.
bool is_compiled_map(const std::filesystem::path& path);

// Reads the file (empty: there is none) into `config` and `sections`, which are all that it may
// name (the drives' sections point into `config`, those of passes hold their options), then the
// overrides ("section.key=value"). Paths become relative to the file's folder; options of passes
// become `config.passes`. Folders and lists of recordings become drives. Errors: those of
// read_yaml, set_override and expand_recordings, missing-key (no mapping drive and no finished map,
// or such a map without a route), bad-value (two different worlds of a finished map, an empty list
// of drives, errors from outside of several drives; a mapping drive beside a finished map, or what
// such a map cannot do without a localization drive: errors of pcl-ndt or from outside; a localizer
// of import-errors without a good name, or parameters that are none; pcl-ndt in a program without
// PCL).
Result<void> read_compile_config(const std::filesystem::path& file,
                                 const std::vector<std::string>& overrides,
                                 std::vector<ConfigSection> sections, CompileConfig& config);

// Every value that `config` sets, as texts, by section and key.
struct EffectiveValue {
  std::string section;
  std::string key;
  std::string value;
};
std::vector<EffectiveValue> effective_values(CompileConfig config);

}  // namespace sightline
