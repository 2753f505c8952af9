#include "compiler/driver/configuration.h"
#include "compiler/driver/pipelines.h"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "formats/base/files/atomic_file.h"
#include "passes/factors/factors_of_sites.h"
#include "passes/localize/measure_error.h"
#include "passes/map/build_ndt.h"
#include "passes/model/train_model.h"
#include "passes/rays/cast_rays.h"
#include "passes/rays/cast_scans.h"
#include "tests/support/json_schema.h"
#include "tests/support/scratch_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

const fs::path kRoot = SIGHTLINE_ROOT;

Result<CompileConfig> load(const std::string& yaml,
                           const std::vector<std::string>& overrides = {}) {
  const fs::path file = scratch_folder() / "compile_config_test" / "drive.yaml";
  EXPECT_TRUE(write_file_atomically(file, yaml, IfExists::kReplace));
  return load_compile_config(file, overrides);
}

// What a step of the compile runs with.
std::string option_of(const CompileConfig& config, const std::string& step,
                      const std::string& option) {
  const CompilePlan compile = compile_plan(config);
  for (const PassStep& planned : compile.plan.steps()) {
    if (planned.name != step) continue;
    for (const auto& [name, value] : planned.options) {
      if (name == option) return value;
    }
  }
  return "no such option";
}

// YAML as JSON: plain scalars become numbers and booleans where they read as such.
nlohmann::json json_of(const YAML::Node& node) {
  nlohmann::json json;
  if (node.IsMap()) {
    for (const auto& entry : node) json[entry.first.Scalar()] = json_of(entry.second);
  } else if (node.IsSequence()) {
    json = nlohmann::json::array();
    for (const YAML::Node& item : node) json.push_back(json_of(item));
  } else if (node.IsScalar()) {
    json = nlohmann::json::parse(node.Scalar(), nullptr, false);
    const bool is_quoted = node.Tag() == "!";
    if (is_quoted || json.is_discarded()) json = node.Scalar();
  }
  return json;
}

bool is_valid(const nlohmann::json& document) {
  const nlohmann::json published =
      nlohmann::json::parse(*read_text_file(kRoot / "schemas/config.schema.json"));
  return schema_faults(published, document).empty();
}

TEST(CompileConfig, IsDescribedByThePublishedSchema) {
  CompileConfig config;
  const Result<std::string> published = read_text_file(kRoot / "schemas/config.schema.json");
  ASSERT_TRUE(published.has_value());
  EXPECT_TRUE(*published == to_json_schema(published_sections(config)))
      << "run tests/update_golden.sh and review the diff";
}

TEST(CompileConfig, OfTheExampleIsValidByAnIndependentValidator) {
  EXPECT_TRUE(is_valid(json_of(YAML::LoadFile((kRoot / "examples/town/town.yaml").string()))));
  CompileConfig config;
  EXPECT_TRUE(is_valid(json_of(YAML::Load(to_yaml(published_sections(config))))));
  EXPECT_TRUE(is_valid(json_of(YAML::Load("mapping: {scans: a, columns: 4}"))));
  EXPECT_TRUE(is_valid(json_of(YAML::Load("mapping: {scans: a, columns: x y z intensity}"))));
  EXPECT_FALSE(is_valid(json_of(YAML::Load("build-ndt: {cel_m: 1.0}"))));
  EXPECT_FALSE(is_valid(json_of(YAML::Load("build-ndt: {cell_m: -1.0}"))));
}

TEST(CompileConfig, TakesAListOfDrivesThatMakeTheMap) {
  const Result<CompileConfig> config = load(
      "mapping:\n"
      "  - {scans: monday, poses: monday.tum, sensor: vlp-16, rate_hz: 20}\n"
      "  - {scans: tuesday}\n"
      "  - {scans: wednesday, name: third, rate_hz: 5}\n");
  ASSERT_TRUE(config.has_value()) << to_string(config.error());
  EXPECT_TRUE(config->mapping.scans.ends_with("/monday"));
  ASSERT_EQ(config->later_mapping.size(), 2U);
  const RecordingOptions& tuesday = config->later_mapping[0];
  EXPECT_TRUE(tuesday.scans.ends_with("compile_config_test/tuesday"));
  EXPECT_EQ(tuesday.poses, "") << "those of Monday are not its own";
  EXPECT_EQ(tuesday.sensor, "vlp-16");
  EXPECT_EQ(tuesday.rate_hz, 20.0);
  EXPECT_EQ(config->later_mapping[1].name, "third");
  EXPECT_EQ(config->later_mapping[1].rate_hz, 5.0);
  const CompilePlan compile = compile_plan(*config);
  std::vector<std::string> roles;
  for (const RecordingInput& input : compile.recordings) roles.push_back(input.role);
  EXPECT_EQ(roles, (std::vector<std::string>{"mapping", "mapping[2]", "mapping[3]"}));
  const std::vector<EffectiveValue> values = effective_values(*config);
  EXPECT_TRUE(std::ranges::any_of(values, [](const EffectiveValue& value) {
    return value.section == "mapping[3]" && value.key == "rate_hz" && value.value == "5";
  }));
  EXPECT_TRUE(is_valid(json_of(YAML::Load("mapping: [{scans: a}, {scans: b}]"))));
  EXPECT_FALSE(is_valid(json_of(YAML::Load("mapping: [{scans: a}, {scan: b}]"))));
}

std::vector<std::string> steps_of(const CompilePlan& compile) {
  std::vector<std::string> names;
  for (const PassStep& step : compile.plan.steps()) names.push_back(step.name);
  return names;
}

TEST(CompileConfig, TakesAListOfDrivesThatAreLocalized) {
  const Result<CompileConfig> config = load(
      "mapping: {scans: map}\n"
      "localization:\n"
      "  - {scans: monday, poses: monday.tum, sensor: vlp-16}\n"
      "  - {scans: tuesday}\n"
      "  - {scans: wednesday, name: third}\n");
  ASSERT_TRUE(config.has_value()) << to_string(config.error());
  EXPECT_FALSE(config->is_split());
  ASSERT_EQ(config->later_localization.size(), 2U);
  EXPECT_TRUE(config->later_localization[0].scans.ends_with("compile_config_test/tuesday"));
  EXPECT_EQ(config->later_localization[0].poses, "") << "those of Monday are not its own";
  EXPECT_EQ(config->later_localization[0].sensor, "vlp-16");
  const CompilePlan compile = compile_plan(*config);
  std::vector<std::string> roles;
  for (const RecordingInput& input : compile.recordings) roles.push_back(input.role);
  EXPECT_EQ(roles, (std::vector<std::string>{"mapping", "localization", "localization[2]",
                                             "localization[3]"}));
  const std::vector<std::string> steps = steps_of(compile);
  const auto number_of = [&](const std::string& name) {
    EXPECT_EQ(std::ranges::count(steps, name), 1) << name;
    return std::ranges::find(steps, name) - steps.begin();
  };
  EXPECT_LT(number_of("measure-error:localization[3]"), number_of("join-errors:localization[3]"));
  EXPECT_LT(number_of("join-errors:localization[3]"), number_of("pool-errors"));
  EXPECT_LT(number_of("pool-errors"), number_of("train-model"));
  EXPECT_EQ(std::ranges::count(steps, "add-history"), 0) << "a map's own drives are its labels";
  EXPECT_EQ(std::ranges::count(steps_of(compile_plan(*config, ModelSource::kGiven)), "add-history"),
            1);
  EXPECT_TRUE(is_valid(json_of(YAML::Load("localization: [{scans: a}, {scans: b}]"))));
  EXPECT_FALSE(is_valid(json_of(YAML::Load("localization: []"))));
}

TEST(CompileConfig, ReleasedDrivesAreUndistortedForTheEstimateInEveryCase) {
  const Result<CompileConfig> config = load(
      "base: old.slposes\nmapping: [{scans: a}, {scans: b}]\n"
      "undistort-scans: {enabled: false}\n");
  ASSERT_TRUE(config.has_value()) << to_string(config.error());
  const CompilePlan compile = compile_plan(*config);
  const auto is_enabled = [&](const std::string& name) {
    const auto step = std::ranges::find(compile.plan.steps(), name, &PassStep::name);
    EXPECT_NE(step, compile.plan.steps().end()) << name;
    for (const auto& [option, value] : step->options) {
      if (option == "enabled") return value;
    }
    return std::string("none");
  };
  EXPECT_EQ(is_enabled("undistort-scans:released"), "true");
  EXPECT_EQ(is_enabled("undistort-scans"), "false");
}

// A list of one is the drive alone: the same steps, and so the same map.
TEST(CompileConfig, AListOfOneDriveIsThatDrive) {
  const Result<CompileConfig> one = load("mapping: {scans: a}\nlocalization: {scans: b}\n");
  const Result<CompileConfig> list = load("mapping: {scans: a}\nlocalization: [{scans: b}]\n");
  ASSERT_TRUE(one.has_value() && list.has_value());
  for (const ModelSource model : {ModelSource::kTrained, ModelSource::kGiven}) {
    EXPECT_EQ(steps_of(compile_plan(*one, model)), steps_of(compile_plan(*list, model)));
  }
  EXPECT_FALSE(compile_plan(*list).measured_drives.is_connected());
}

TEST(CompileConfig, RefusesAListOfLocalizationDrivesThatCannotBe) {
  const auto refused = [](const std::string& text, ErrorCode code, const std::string& says) {
    const Result<CompileConfig> config = load("mapping: {scans: a}\n" + text);
    ASSERT_FALSE(config.has_value()) << text;
    EXPECT_EQ(config.error().code, code) << to_string(config.error());
    EXPECT_NE(to_string(config.error()).find(says), std::string::npos) << to_string(config.error());
  };
  refused("localization: []\n", ErrorCode::kBadValue, "the list is empty");
  refused("localization: [{scans: b}, {name: c}]\n", ErrorCode::kMissingKey,
          "localization[2].scans");
  refused("localization: [{scans: b}, {scans: c}, {scans: ./b}]\n", ErrorCode::kBadValue,
          "localization[3].scans: found the recording of localization,");
  refused("localization: [{scans: b}, {scan: c}]\n", ErrorCode::kUnknownKey, "drive 2");
  refused(
      "localization: [{scans: b}, {scans: c}]\n"
      "import-errors: {file: errors.csv, localizer: mine}\n",
      ErrorCode::kBadValue, "import-errors.file is of one localization drive, and 2 are named");
}

// A compiled map, as far as its first bytes show.
void write_map(const std::string& name) {
  const std::string_view beginning("\x89SLM\r\n\x1a\n and more", 17);
  ASSERT_TRUE(write_file_atomically(scratch_folder() / "compile_config_test" / name, beginning,
                                    IfExists::kReplace));
}

TEST(CompileConfig, KnowsACompiledMapByItsContent) {
  write_map("renamed.map");
  const Result<CompileConfig> renamed = load("map: renamed.map\nroute: everywhere\n");
  ASSERT_TRUE(renamed.has_value()) << to_string(renamed.error());
  EXPECT_TRUE(renamed->map.is_compiled);
  ASSERT_TRUE(write_file_atomically(scratch_folder() / "compile_config_test" / "cloud.slmap",
                                    std::string_view("# .PCD v0.7"), IfExists::kReplace));
  const Result<CompileConfig> cloud = load("map: cloud.slmap\nroute: everywhere\n");
  ASSERT_TRUE(cloud.has_value()) << to_string(cloud.error());
  EXPECT_FALSE(cloud->map.is_compiled);
}

TEST(CompileConfig, AMapAndARouteMayBeOneWordEach) {
  write_map("city.slmap");
  const Result<CompileConfig> config = load("map: city.slmap\nroute: everywhere\n");
  ASSERT_TRUE(config.has_value()) << to_string(config.error());
  EXPECT_TRUE(config->map.points.ends_with("compile_config_test/city.slmap"));
  EXPECT_TRUE(config->map.is_compiled);
  EXPECT_EQ(config->route.file, "everywhere");
  const CompilePlan compile = compile_plan(*config);
  std::vector<std::string> passes;
  for (const PassStep& step : compile.plan.steps()) passes.push_back(step.name);
  EXPECT_EQ(std::vector(passes.begin(), passes.begin() + 4),
            (std::vector<std::string>{"ingest-compiled-map", "build-nd-surface", "pack-nds",
                                      "choose-field-sites"}));
  EXPECT_FALSE(compile.points.is_connected());
  EXPECT_FALSE(config->map.is_apollo);
  const Result<CompileConfig> lanes = load("map: tiles\nroute: lanes.osm\n");
  ASSERT_TRUE(lanes.has_value()) << to_string(lanes.error());
  EXPECT_TRUE(lanes->route.file.ends_with("compile_config_test/lanes.osm"));
  EXPECT_TRUE(is_valid(json_of(YAML::Load("{map: city.slmap, route: everywhere}"))));
  EXPECT_FALSE(is_valid(json_of(YAML::Load("{mapping: scans}"))));
  EXPECT_FALSE(load("mapping: scans\n").has_value());
}

TEST(CompileConfig, NamesTheDriveOfAListThatIsWrong) {
  const Result<CompileConfig> key = load("mapping:\n  - {scans: a}\n  - {scan: b}\n");
  ASSERT_FALSE(key.has_value());
  EXPECT_EQ(key.error().code, ErrorCode::kUnknownKey);
  EXPECT_EQ(key.error().place, "line 3");
  EXPECT_NE(key.error().message.find("drive 2"), std::string::npos) << key.error().message;
  const Result<CompileConfig> none = load("mapping:\n  - {scans: a}\n  - {name: b}\n");
  ASSERT_FALSE(none.has_value());
  EXPECT_EQ(none.error().code, ErrorCode::kMissingKey);
  EXPECT_NE(none.error().message.find("mapping[2].scans"), std::string::npos);
}

TEST(CompileConfig, SpreadsWhatPassesShare) {
  const Result<CompileConfig> config = load(
      "mapping: {scans: a}\nlocalization: {scans: b}\n"
      "annotation: {ranges_m: [5, 35], limits_m: [0.2], leaf_m: 0.5, tile_m: 32}\n");
  ASSERT_TRUE(config.has_value()) << to_string(config.error());
  EXPECT_EQ(config->passes.options(kMeasureError).ranges_m, (std::vector<double>{5.0, 35.0}));
  EXPECT_EQ(config->passes.options(kComputeFactors).ranges_m, (std::vector<double>{5.0, 35.0}));
  EXPECT_EQ(config->passes.options(kCastRays).longest_range_m, 35.0);
  EXPECT_EQ(config->passes.options(kCastScans).leaf_m, 0.5);
  EXPECT_EQ(config->passes.options(kMeasureError).leaf_m, 0.5);
  EXPECT_EQ(config->passes.options(kTrainModel).limits_m, std::vector<double>{0.2});
  EXPECT_EQ(config->passes.options(kBuildNdt).tile_m, 32.0);
  EXPECT_EQ(option_of(*config, "remove-moving", "scans"), "all");
}

TEST(CompileConfig, SplitsARecordingThatIsBothDrives) {
  const Result<CompileConfig> config = load("mapping: {scans: a}\n");
  ASSERT_TRUE(config.has_value()) << to_string(config.error());
  EXPECT_TRUE(config->is_split());
  EXPECT_EQ(option_of(*config, "remove-moving", "scans"), "even");
  EXPECT_EQ(option_of(*config, "choose-sites", "scans"), "even");
  EXPECT_EQ(option_of(*config, "measure-error", "scans"), "odd");
  EXPECT_EQ(option_of(*config, "emit-map", "mapping_scans"), "even");
}

TEST(CompileConfig, TakesPathsFromTheFilesFolderAndOverridesFromTheCommandLine) {
  const Result<CompileConfig> config =
      load("mapping: {scans: a/scans, poses: ../p.tum}\n", {"build-ndt.cell_m=1.0"});
  ASSERT_TRUE(config.has_value());
  const fs::path folder = scratch_folder() / "compile_config_test";
  EXPECT_EQ(config->mapping.scans, (folder / "a/scans").string());
  EXPECT_EQ(fs::path(config->mapping.poses), scratch_folder() / "p.tum");
  EXPECT_EQ(config->passes.options(kBuildNdt).cell_m, 1.0);
}

TEST(CompileConfig, TakesErrorsOfALocalizerOutsideInPlaceOfMeasuringThem) {
  const Result<CompileConfig> config = load(
      "mapping: {scans: a}\nimport-errors: {file: e.csv, localizer: my-ndt, version: 4, "
      "parameters: 'voxel_m = 3,box_m=60'}\n");
  ASSERT_TRUE(config.has_value()) << to_string(config.error());
  EXPECT_EQ(config->outside.file, (scratch_folder() / "compile_config_test/e.csv").string());
  EXPECT_EQ(to_text(*outside_localizer(config->outside)), "my-ndt v4 (box_m=60, voxel_m=3)");
  EXPECT_EQ(option_of(*config, "import-errors", "scans"), "odd");
  EXPECT_EQ(option_of(*config, "measure-error", "scans"), "no such option");
}

TEST(CompileConfig, RefusesALocalizerOutsideThatAVehicleCouldNotName) {
  for (const char* keys :
       {"", ", localizer: my ndt", ", localizer: searching", ", localizer: a/2",
        ", localizer: a, parameters: leaf", ", localizer: a, parameters: 'x=1, x=2'"}) {
    const Result<CompileConfig> config =
        load("mapping: {scans: a}\nimport-errors: {file: e.csv" + std::string(keys) + "}\n");
    ASSERT_FALSE(config.has_value()) << keys;
    EXPECT_EQ(config.error().code, ErrorCode::kBadValue) << keys;
    EXPECT_NE(config.error().message.find("import-errors."), std::string::npos);
  }
}

TEST(CompileConfig, MakesTheFactorOfTheMappingDriveByItsOwnLocalizerWhoeverLocalizes) {
  const Result<CompileConfig> config =
      load("mapping: {scans: a}\nlocalization: {scans: b}\nmeasure-error: {localizer: pcl-ndt}\n");
  if (!config.has_value()) {
    EXPECT_NE(config.error().message.find("built without PCL"), std::string::npos);
    return;
  }
  EXPECT_EQ(option_of(*config, "measure-error", "localizer"), "pcl-ndt");
  EXPECT_EQ(option_of(*config, "measure-error:own", "localizer"), "searching");
}

TEST(CompileConfig, RefusesNoDriveAndTwoWaysToLocalize) {
  EXPECT_EQ(load("build-ndt: {cell_m: 1.0}\n").error().code, ErrorCode::kMissingKey);
  EXPECT_EQ(load("mapping: {scans: a}\nlocalization: {scans: b}\nannotation: {split: even-odd}\n")
                .error()
                .code,
            ErrorCode::kBadValue);
}

}  // namespace
}  // namespace sightline
