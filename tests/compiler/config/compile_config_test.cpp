#include "compiler/driver/configuration.h"
#include "compiler/driver/evaluate_plan.h"
#include "compiler/driver/pipelines.h"
#include "compiler/driver/provide_inputs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "compiler/config/inputs.h"
#include "formats/base/files/atomic_file.h"
#include "formats/foreign/clouds/pcd_writer.h"
#include "passes/factors/factors_of_sites.h"
#include "passes/localize/measure_error.h"
#include "passes/map/build_ndt.h"
#include "passes/model/train_model.h"
#include "passes/rays/cast_rays.h"
#include "passes/rays/cast_scans.h"
#include "tests/support/json_schema.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
const fs::path kRoot = SIGHTLINE_ROOT;

Result<CompileConfig> load(const std::string& yaml, const std::vector<std::string>& overrides = {},
                           const std::string& folder = "compile_config_test") {
  const fs::path file = scratch_folder() / folder / "drive.yaml";
  EXPECT_TRUE(write_file_atomically(file, yaml, IfExists::kReplace));
  return load_compile_config(file, overrides);
}

std::string option_of(const Plan& plan, const std::string& step, const std::string& option) {
  for (const PassStep& planned : plan.steps()) {
    if (planned.name != step) continue;
    for (const auto& [name, value] : planned.options) {
      if (name == option) return value;
    }
  }
  return "no such option";
}

std::string option_of(const CompileConfig& config, const std::string& step,
                      const std::string& option) {
  return option_of(compile_plan(config).plan, step, option);
}

std::vector<std::string> texts_of(const CompileConfig& config) {
  std::vector<std::string> texts;
  for (const EffectiveValue& value : effective_values(config)) {
    texts.push_back(value.section + "." + value.key + "=" + value.value);
  }
  return texts;
}

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
  const std::string published = value_of(read_text_file(kRoot / "schemas/config.schema.json"));
  EXPECT_TRUE(published == to_json_schema(published_sections(config)))
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

TEST(CompileConfig, ListsEachRecordingOnceWithItsRole) {
  CompileConfig config;
  config.later_mapping.resize(2);
  config.later_localization.resize(1);
  std::vector<std::string> roles;
  std::vector<std::string> later;
  visit_recordings(config, [&](const RecordingRole& role, RecordingOptions& recording) {
    recording.name = to_text(role);
    roles.push_back(recording.name);
    if (role.is_later()) later.push_back(recording.name);
  });
  EXPECT_EQ(roles, (std::vector<std::string>{"mapping", "mapping[2]", "mapping[3]", "mapping-2",
                                             "mapping-3", "mapping-4", "localization",
                                             "localization[2]", "evaluation"}));
  EXPECT_EQ(later, (std::vector<std::string>{"mapping[2]", "mapping[3]", "localization[2]"}));
  EXPECT_EQ(config.later_mapping[1].name, "mapping[3]");
  EXPECT_EQ(config.other_sensors[0].name, "mapping-2");
}

TEST(CompileConfig, TakesAListOfDrivesThatMakeTheMap) {
  const CompileConfig config =
      value_of(load("mapping:\n"
                    "  - {scans: monday, poses: monday.tum, sensor: vlp-16, rate_hz: 20}\n"
                    "  - {scans: tuesday}\n"
                    "  - {scans: wednesday, name: third, rate_hz: 5}\n"));
  EXPECT_TRUE(config.mapping.scans.ends_with("/monday"));
  ASSERT_EQ(config.later_mapping.size(), 2U);
  const RecordingOptions& tuesday = config.later_mapping[0];
  EXPECT_TRUE(tuesday.scans.ends_with("compile_config_test/tuesday"));
  EXPECT_EQ(tuesday.poses, "") << "those of Monday are not its own";
  EXPECT_EQ(tuesday.sensor, "vlp-16");
  EXPECT_EQ(tuesday.rate_hz, 20.0);
  EXPECT_EQ(config.later_mapping[1].name, "third");
  EXPECT_EQ(config.later_mapping[1].rate_hz, 5.0);
  const CompilePlan compile = compile_plan(config);
  std::vector<std::string> roles;
  for (const RecordingInput& input : compile.recordings) roles.push_back(input.role);
  EXPECT_EQ(roles, (std::vector<std::string>{"mapping", "mapping[2]", "mapping[3]"}));
  EXPECT_TRUE(std::ranges::any_of(effective_values(config), [](const EffectiveValue& value) {
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
  const CompileConfig config =
      value_of(load("mapping: {scans: map}\n"
                    "localization:\n"
                    "  - {scans: monday, poses: monday.tum, sensor: vlp-16}\n"
                    "  - {scans: tuesday}\n"
                    "  - {scans: wednesday, name: third}\n"));
  EXPECT_FALSE(config.is_split());
  ASSERT_EQ(config.later_localization.size(), 2U);
  EXPECT_TRUE(config.later_localization[0].scans.ends_with("compile_config_test/tuesday"));
  EXPECT_EQ(config.later_localization[0].poses, "") << "those of Monday are not its own";
  EXPECT_EQ(config.later_localization[0].sensor, "vlp-16");
  const CompilePlan compile = compile_plan(config);
  std::vector<std::string> roles;
  for (const RecordingInput& input : compile.recordings) roles.push_back(input.role);
  EXPECT_EQ(roles, (std::vector<std::string>{"mapping", "localization", "localization[2]",
                                             "localization[3]"}));
  const std::vector<std::string> steps = steps_of(compile);
  const auto number_of = [&](const std::string& name) {
    EXPECT_EQ(std::ranges::count(steps, name), 1) << name;
    return std::ranges::find(steps, name) - steps.begin();
  };
  EXPECT_LT(number_of("measure-error:localization[3]"), number_of("join-errors"));
  EXPECT_LT(number_of("join-errors"), number_of("pool-errors"));
  EXPECT_LT(number_of("pool-errors"), number_of("train-model"));
  EXPECT_EQ(std::ranges::count(steps, "add-history"), 0) << "a map's own drives are its labels";
  EXPECT_EQ(std::ranges::count(steps_of(compile_plan(config, ModelSource::kGiven)), "add-history"),
            1);
  EXPECT_TRUE(is_valid(json_of(YAML::Load("localization: [{scans: a}, {scans: b}]"))));
  EXPECT_FALSE(is_valid(json_of(YAML::Load("localization: []"))));
}

TEST(CompileConfig, ReleasedDrivesAreUndistortedForTheEstimateInEveryCase) {
  const CompileConfig config =
      value_of(load("base: old.slposes\nmapping: [{scans: a}, {scans: b}]\n"
                    "undistort-scans: {enabled: false}\n"));
  const CompilePlan compile = compile_plan(config);
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
    const Error config = failure_of(load("mapping: {scans: a}\n" + text), text);
    EXPECT_EQ(config.code, code) << to_string(config);
    EXPECT_NE(to_string(config).find(says), std::string::npos) << to_string(config);
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
      ErrorCode::kBadValue,
      "import-errors.file has the errors of one localization drive, and 2 are listed");
}

void write_map(const std::string& name) {
  const std::string_view beginning("\x89SLM\r\n\x1a\n and more", 17);
  ASSERT_TRUE(write_file_atomically(scratch_folder() / "compile_config_test" / name, beginning,
                                    IfExists::kReplace));
}

TEST(CompileConfig, KnowsACompiledMapByItsContent) {
  write_map("renamed.map");
  EXPECT_TRUE(value_of(load("map: renamed.map\nroute: everywhere\n")).map.is_compiled);
  ASSERT_TRUE(write_file_atomically(scratch_folder() / "compile_config_test" / "cloud.slmap",
                                    std::string_view("# .PCD v0.7"), IfExists::kReplace));
  EXPECT_FALSE(value_of(load("map: cloud.slmap\nroute: everywhere\n")).map.is_compiled);
}

TEST(CompileConfig, AFinishedMapHasTheWorldOfEitherKey) {
  const auto worlds_of = [](const std::string& of_map, const std::string& of_route) {
    const Result<CompileConfig> config =
        load("map: tiles\nroute: everywhere\n",
             {"annotation.world=" + of_map, "route.world=" + of_route});
    if (!config) return config.error().message;
    return config->annotation.world + " " + config->route.world;
  };
  EXPECT_EQ(worlds_of("local", "local"), "local local");
  EXPECT_EQ(worlds_of("local", "utm:52N"), "utm:52N utm:52N");
  EXPECT_EQ(worlds_of("utm:52N", "local"), "utm:52N utm:52N");
  EXPECT_EQ(worlds_of("utm:52N", "utm:52N"), "utm:52N utm:52N");
  EXPECT_THAT(
      worlds_of("utm:52N", "utm:32N"),
      testing::HasSubstr("annotation.world is utm:52N, but route.world (--world) is utm:32N"));
}

TEST(CompileConfig, AMapAndARouteMayBeOneWordEach) {
  write_map("city.slmap");
  const CompileConfig config = value_of(load("map: city.slmap\nroute: everywhere\n"));
  EXPECT_TRUE(config.map.points.ends_with("compile_config_test/city.slmap"));
  EXPECT_TRUE(config.map.is_compiled);
  EXPECT_EQ(config.route.file, "everywhere");
  const CompilePlan compile = compile_plan(config);
  std::vector<std::string> passes;
  for (const PassStep& step : compile.plan.steps()) passes.push_back(step.name);
  EXPECT_EQ(std::vector(passes.begin(), passes.begin() + 4),
            (std::vector<std::string>{"ingest-compiled-map", "build-nd-surface",
                                      "choose-field-sites", "pack-nds"}));
  EXPECT_FALSE(compile.points.is_connected());
  EXPECT_FALSE(config.map.is_apollo);
  const CompileConfig lanes = value_of(load("map: tiles\nroute: lanes.osm\n"));
  EXPECT_TRUE(lanes.route.file.ends_with("compile_config_test/lanes.osm"));
  EXPECT_TRUE(is_valid(json_of(YAML::Load("{map: city.slmap, route: everywhere}"))));
  EXPECT_FALSE(is_valid(json_of(YAML::Load("{mapping: scans}"))));
  EXPECT_FALSE(load("mapping: scans\n").has_value());
}

TEST(CompileConfig, NamesTheDriveOfAListThatIsWrong) {
  const Error key = failure_of(load("mapping:\n  - {scans: a}\n  - {scan: b}\n"));
  EXPECT_EQ(key.code, ErrorCode::kUnknownKey);
  EXPECT_EQ(key.place, "line 3, column 6");
  EXPECT_NE(key.message.find("drive 2"), std::string::npos) << key.message;
  const Error none = failure_of(load("mapping:\n  - {scans: a}\n  - {name: b}\n"));
  EXPECT_EQ(none.code, ErrorCode::kMissingKey);
  EXPECT_NE(none.message.find("mapping[2].scans"), std::string::npos);
}

TEST(CompileConfig, SpreadsWhatPassesShare) {
  const CompileConfig config =
      value_of(load("mapping: {scans: a}\nlocalization: {scans: b}\n"
                    "annotation: {ranges_m: [5, 35], limits_m: [0.2], leaf_m: 0.5, tile_m: 32}\n"));
  EXPECT_EQ(config.passes.options(kMeasureError).ranges_m, (std::vector<double>{5.0, 35.0}));
  EXPECT_EQ(config.passes.options(kComputeFactors).ranges_m, (std::vector<double>{5.0, 35.0}));
  EXPECT_EQ(config.passes.options(kCastRays).longest_range_m, 35.0);
  EXPECT_EQ(config.passes.options(kCastScans).leaf_m, 0.5);
  EXPECT_EQ(config.passes.options(kMeasureError).leaf_m, 0.5);
  EXPECT_EQ(config.passes.options(kTrainModel).limits_m, std::vector<double>{0.2});
  EXPECT_EQ(config.passes.options(kBuildNdt).tile_m, 32.0);
  EXPECT_EQ(option_of(config, "remove-moving", "scans"), "all");
}

TEST(CompileConfig, SplitsARecordingThatIsBothDrives) {
  const CompileConfig config = value_of(load("mapping: {scans: a}\n"));
  EXPECT_TRUE(config.is_split());
  EXPECT_EQ(option_of(config, "remove-moving", "scans"), "even");
  EXPECT_EQ(option_of(config, "choose-sites", "scans"), "even");
  EXPECT_EQ(option_of(config, "measure-error", "scans"), "odd");
  EXPECT_EQ(option_of(config, "emit-map", "mapping_scans"), "even");
}

class SameRecordings : public testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(folder_);
    for (const auto& [name, first_x_m] :
         {std::pair{"a/0.pcd", 1.0F}, {"b/10.pcd", 1.0F}, {"c/0.pcd", 3.0F}}) {
      const fs::path file = folder_ / name;
      fs::create_directories(file.parent_path());
      write_scan(file, first_x_m);
      write_scan(file.parent_path() / "11.pcd", first_x_m + 1.0F);
    }
    fs::create_directory_symlink("a", folder_ / "link");
  }
  static void write_scan(const fs::path& file, float x_m) {
    const PointXyzi point{x_m, 2.0F, 3.0F, 0.0F};
    ASSERT_TRUE(write_pcd_binary(file, std::span(&point, 1)));
  }
  static Result<CompileConfig> load_here(const std::string& yaml) {
    return load(yaml, {}, "same_recordings");
  }
  static Result<void> open(const std::string& yaml) {
    SIGHTLINE_ASSIGN(const CompileConfig config, load_here(yaml));
    ArtifactSet artifacts;
    return provide_drives(compile_plan(config), {}, artifacts);
  }
  static void expect_refused(const std::string& yaml, const std::string& one,
                             const std::string& other) {
    const Error opened = failure_of(open(yaml), yaml);
    EXPECT_EQ(opened.code, ErrorCode::kBadValue);
    const std::string expected = one + ".scans: found the recording of " + other;
    EXPECT_NE(opened.message.find(expected), std::string::npos) << opened.message;
  }

  const fs::path folder_ = scratch_folder() / "same_recordings";
};

TEST_F(SameRecordings, TwiceInOneRoleAreRefused) {
  for (const char* again : {"a", "a/", "./a", "c/../a", "link", "link/", "b"}) {
    const std::string more = std::string(again) + "}";
    expect_refused("mapping: [{scans: a}, {scans: c}, {scans: " + more + "]\n", "mapping[3]",
                   "mapping");
    expect_refused("mapping: {scans: c}\nlocalization: [{scans: a}, {scans: " + more + "]\n",
                   "localization[2]", "localization");
    expect_refused("mapping: {scans: a}\nmapping-2: {scans: " + more + "\n", "mapping-2",
                   "mapping");
  }
  EXPECT_TRUE(open("mapping: [{scans: a}, {scans: c}]\n"));
}

TEST_F(SameRecordings, AsMappingAndLocalizationAreTheSplit) {
  const CompileConfig split = *load_here("mapping: {scans: a, name: town}\n");
  EXPECT_TRUE(split.notes.empty());
  for (const char* again : {"{scans: a}", "{scans: a/}", "{scans: ./a}", "{scans: link/}",
                            "{scans: b, name: other}", "[{scans: a, sensor: vlp-16}]"}) {
    const std::string yaml =
        std::string("mapping: {scans: a, name: town}\nlocalization: ") + again + "\n";
    const CompileConfig config = value_of(load_here(yaml));
    EXPECT_TRUE(config.is_split()) << again;
    EXPECT_EQ(option_of(config, "emit-map", "mapping_scans"), "even");
    EXPECT_EQ(texts_of(config), texts_of(split)) << again;
    ASSERT_EQ(config.notes.size(), 1U);
    EXPECT_NE(config.notes[0].find("localization.scans: found the recording of mapping"),
              std::string::npos);
  }
  EXPECT_FALSE(load_here("mapping: {scans: a}\nlocalization: {scans: c}\n")->is_split());
}

TEST_F(SameRecordings, TheEvaluationDriveMayBeAnotherDriveUnlessAModelLearnsFromIt) {
  const CompileConfig config = value_of(
      load_here("mapping: {scans: a}\nlocalization: {scans: c}\nevaluation: {scans: c/}\n"));
  CompilePlan compile = compile_plan(config);
  measure_evaluation_drive(config, compile);
  ArtifactSet artifacts;
  require(provide_drives(compile, {}, artifacts));
  compile.learns_from_evaluation = true;
  ArtifactSet more;
  EXPECT_EQ(provide_drives(compile, {}, more).error().code, ErrorCode::kBadValue);
}

TEST_F(SameRecordings, ErrorsFromOutsideAreNotOfADriveThatMakesTheMap) {
  const Error config =
      failure_of(load_here("mapping: {scans: a}\nlocalization: {scans: a}\n"
                           "import-errors: {file: errors.csv, localizer: mine}\n"));
  EXPECT_NE(config.message.find("import-errors has errors of all"), std::string::npos)
      << config.message;
}

TEST_F(SameRecordings, OneOfSeveralLocalizationDrivesIsNoMappingDrive) {
  expect_refused("mapping: {scans: a}\nlocalization: [{scans: c}, {scans: link}]\n",
                 "localization[2]", "mapping");
}

TEST_F(SameRecordings, TheSplitDriveIsJudgedByItsOtherScansHoweverItIsNamed) {
  const auto judging_scans = [](const std::string& evaluation,
                                const std::string& mapping_scans = "even") {
    CompileConfig config =
        *load_here("mapping: {scans: a}\nevaluation: {scans: " + evaluation + "}\n");
    CompiledMap map;
    map.measurement.mapping_scans = mapping_scans;
    const EvaluatePlan evaluate = evaluate_plan(config, map);
    const std::string scans = option_of(evaluate.plan, "measure-error:evaluation", "scans");
    EXPECT_EQ(evaluate.judges_other_scans, scans == "odd");
    return scans;
  };
  for (const char* same : {"a", "a/", "./a", "link", "link/", "b"}) {
    EXPECT_EQ(judging_scans(same), "odd") << same;
  }
  EXPECT_EQ(judging_scans("c"), "all");
  EXPECT_EQ(judging_scans("a", "all"), "all") << "all scans made the map";
}

TEST_F(SameRecordings, AKnownEvaluationDriveIsFoundWhateverItsOtherKeys) {
  const std::string drives = "mapping: {scans: a}\nlocalization: {scans: c}\n";
  const auto is_known = [&](const std::string& evaluation) {
    return is_known_evaluation(*load_here(drives + "evaluation: {" + evaluation + "}\n"));
  };
  EXPECT_TRUE(is_known("scans: b, rate_hz: 5, name: evening, height_m: 2, sensor: hdl-32e"));
  EXPECT_TRUE(is_known("scans: c/, name: evening"));
  EXPECT_FALSE(is_known("scans: d"));
}

TEST(CompileConfig, DrivesWithoutASensorHaveThatOfTheMappingDrive) {
  const CompileConfig config =
      value_of(load("mapping: {scans: a, sensor: hdl-64e, height_m: 1.7, lidar_x_m: 0.5}\n"
                    "localization: [{scans: b}, {scans: c}]\n"
                    "evaluation: {scans: d, sensor: generic-16}\n"));
  for (const RecordingOptions& drive : {config.localization, config.later_localization.front()}) {
    EXPECT_EQ(drive.sensor, "hdl-64e");
    EXPECT_EQ(drive.height_m, 1.7);
    EXPECT_EQ(drive.lidar_x_m, 0.5);
  }
  EXPECT_EQ(config.evaluation.sensor, "generic-16") << "named";
  EXPECT_EQ(config.evaluation.height_m, 0.0);
  const CompileConfig own =
      value_of(load("mapping: {scans: a, sensor: hdl-64e, height_m: 1.7, lidar_x_m: 0.5}\n"
                    "evaluation: {scans: b, height_m: 2, lidar_y_m: 0.1}\n"));
  EXPECT_EQ(own.evaluation.sensor, "hdl-64e");
  EXPECT_EQ(own.evaluation.height_m, 2.0);
  EXPECT_EQ(own.evaluation.lidar_x_m, 0.0) << "mounted elsewhere";
  const CompileConfig finished = value_of(load(
      "map: {points: a.pcd, sensor: os1-64}\nroute: {file: r.tum}\nlocalization: {scans: b}\n"));
  EXPECT_EQ(finished.localization.sensor, "os1-64");
}

TEST(CompileConfig, TakesPathsFromTheFilesFolderAndOverridesFromTheCommandLine) {
  const CompileConfig config =
      value_of(load("mapping: {scans: a/scans, poses: ../p.tum}\n", {"build-ndt.cell_m=1.0"}));
  const fs::path folder = scratch_folder() / "compile_config_test";
  EXPECT_EQ(config.mapping.scans, (folder / "a/scans").string());
  EXPECT_EQ(fs::path(config.mapping.poses), scratch_folder() / "p.tum");
  EXPECT_EQ(config.passes.options(kBuildNdt).cell_m, 1.0);
}

TEST(CompileConfig, TakesErrorsOfALocalizerOutsideInPlaceOfMeasuringThem) {
  const CompileConfig config = value_of(
      load("mapping: {scans: a}\nimport-errors: {file: e.csv, localizer: my-ndt, version: 4, "
           "parameters: 'voxel_m = 3,box_m=60'}\n"));
  EXPECT_EQ(config.outside.file, (scratch_folder() / "compile_config_test/e.csv").string());
  EXPECT_EQ(to_text(*outside_localizer(config.outside)), "my-ndt v4 (box_m=60, voxel_m=3)");
  EXPECT_EQ(option_of(config, "import-errors", "scans"), "odd");
  EXPECT_EQ(option_of(config, "measure-error", "scans"), "no such option");
}

TEST(CompileConfig, RefusesALocalizerOutsideThatAVehicleCouldNotName) {
  for (const char* keys :
       {"", ", localizer: my ndt", ", localizer: searching", ", localizer: a/2",
        ", localizer: a, parameters: leaf", ", localizer: a, parameters: 'x=1, x=2'"}) {
    const Error config = failure_of(
        load("mapping: {scans: a}\nimport-errors: {file: e.csv" + std::string(keys) + "}\n"), keys);
    EXPECT_EQ(config.code, ErrorCode::kBadValue) << keys;
    EXPECT_NE(config.message.find("import-errors."), std::string::npos);
  }
}

TEST(CompileConfig, MakesTheFactorOfTheMappingDriveByItsOwnLocalizerWhoeverLocalizes) {
  const Result<CompileConfig> config =
      load("mapping: {scans: a}\nlocalization: {scans: b}\nmeasure-error: {localizer: pcl-ndt}\n");
  if (!config.has_value()) {
    EXPECT_NE(config.error().message.find("built without PCL"), std::string::npos);
    EXPECT_NE(config.error().message.find("libpcl-dev"), std::string::npos);
    return;
  }
  EXPECT_EQ(option_of(*config, "measure-error", "localizer"), "pcl-ndt");
  EXPECT_EQ(option_of(*config, "measure-error:own", "localizer"), "searching");
}

TEST(CompileConfig, RefusesNoDriveAndTwoWaysToLocalize) {
  EXPECT_EQ(load("build-ndt: {cell_m: 1.0}\n").error().code, ErrorCode::kMissingKey);
  EXPECT_EQ(code_of(load(
                "mapping: {scans: a}\nlocalization: {scans: b}\nannotation: {split: even-odd}\n")),
            ErrorCode::kBadValue);
}

}  // namespace
}  // namespace sightline
