#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>

#include "formats/base/files/atomic_file.h"
#include "tests/support/json_schema.h"
#include "tests/system/program.h"

namespace sightline {
namespace {

nlohmann::json schema(const std::string& name) {
  return nlohmann::json::parse(
      *read_text_file(std::filesystem::path(SIGHTLINE_ROOT) / "schemas" / (name + ".schema.json")));
}

// What is wrong with the tables of `evaluate --json`; empty: nothing.
std::string fault_of_evaluation(const std::string& json_text) {
  const nlohmann::json document = nlohmann::json::parse(json_text, nullptr, false);
  if (document.is_discarded()) return "no JSON";
  return schema_faults(schema("evaluation"), document);
}

// A schema that takes anything would prove nothing.
TEST(Evaluate, TheSchemaRefusesATableThatIsNoneAndAColumnTooMany) {
  EXPECT_NE(fault_of_evaluation("[]"), "");
  EXPECT_NE(
      fault_of_evaluation("[{\"name\": \"x\", \"facts\": {}, \"columns\": [], \"rows\": []}]"), "");
  EXPECT_NE(fault_of_evaluation("{"), "");
}

std::string config() { return (small_town() / "town.yaml").string(); }

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

// At most so many lines, none too wide for a terminal.
void expect_lines(const std::string& text, std::size_t most) {
  const std::vector<std::string> lines = lines_of(text);
  EXPECT_LE(lines.size(), most) << text;
  for (const std::string& line : lines) EXPECT_LE(line.size(), 120U) << line;
}

// What a verb prints that wrote a map or a page.
void expect_summary(const std::string& text, const std::string& file) {
  EXPECT_EQ(text.rfind("Wrote " + file + " (", 0), 0U) << text;
  EXPECT_NE(text.find(" places, "), std::string::npos) << text;
  EXPECT_NE(text.find("\nVerdict: "), std::string::npos) << text;
  EXPECT_NE(text.find("\nNext: "), std::string::npos) << text;
  EXPECT_LE(lines_of(text).size(), 6U) << text;
}

const std::filesystem::path& compiled_map() {
  static const std::filesystem::path kMap = [] {
    const std::filesystem::path map = small_town() / "town.slmap";
    const ProgramResult run = run_successfully("compile " + config() + " -o " + map.string());
    expect_summary(run.out, map.string());
    return map;
  }();
  return kMap;
}

TEST(Compile, GivesTheSameBytesWithOneThreadAndWithTwo) {
  const std::filesystem::path folder = fresh_folder();
  for (const char* threads : {"1", "2"}) {
    run_successfully("compile " + config() + " --no-cache --threads " + threads + " -q -o " +
                     (folder / threads).string() + ".slmap");
  }
  const std::string one = bytes_of(folder / "1.slmap");
  EXPECT_GT(one.size(), 10'000U);
  EXPECT_TRUE(one == bytes_of(folder / "2.slmap"));
  EXPECT_TRUE(one == bytes_of(compiled_map())) << "a cached compile differs from an uncached one";
}

TEST(Compile, RunsNothingTwiceAndOnlyWhatAChangeReaches) {
  const std::filesystem::path folder = fresh_folder();
  compiled_map();
  const std::string again = "compile " + config() + " -q --explain -o ";
  const ProgramResult unchanged = run_successfully(again + (folder / "a.slmap").string());
  EXPECT_NE(unchanged.err.find("kept  measure-error: unchanged"), std::string::npos);
  EXPECT_NE(unchanged.err.find("kept  train-model: unchanged"), std::string::npos);
  const ProgramResult changed = run_successfully(again + (folder / "b.slmap").string() +
                                                 " --set choose-ranges.selection=mean");
  EXPECT_NE(changed.err.find("kept  predict-error: unchanged"), std::string::npos);
  EXPECT_NE(changed.err.find("ran   choose-ranges: option selection was probability, is mean"),
            std::string::npos)
      << changed.err;
}

TEST(Compile, DrawsTheRangesOfAMapAndOfItsConfiguration) {
  const std::string map = compiled_map().string();
  for (const std::string& target : {map, config()}) {
    const ProgramResult drawn =
        run_successfully("dump " + target + " -q --what ranges --format svg");
    EXPECT_NE(drawn.out.find("<svg xmlns="), std::string::npos);
    EXPECT_NE(drawn.out.find("within 10 cm"), std::string::npos);
  }
  const ProgramResult refused = run_sightline("dump " + map + " --what ranges --format png");
  EXPECT_EQ(refused.status, 64);
  EXPECT_NE(refused.err.find("ranges are drawn as svg"), std::string::npos) << refused.err;
}

TEST(Compile, RefusesToReplaceItsOutputUnlessForced) {
  const ProgramResult refused =
      run_sightline("compile " + config() + " -q -o " + compiled_map().string());
  EXPECT_EQ(refused.status, 64);
  EXPECT_NE(refused.err.find("SL1005 output-exists"), std::string::npos) << refused.err;
  run_successfully("compile " + config() + " -q --force -o " + compiled_map().string());
}

TEST(Compile, StoppedByASignalKeepsWhatIsDoneAndLeavesNothingHalfWritten) {
  const std::filesystem::path folder = fresh_folder();
  const std::string command = "compile " + config() + " --cache " + (folder / "cache").string() +
                              " -o " + (folder / "map.slmap").string();
  // The signal comes as soon as the trajectory is in the cache.
  const ProgramResult stopped = run_command(std::string(SIGHTLINE_PROGRAM) + " " + command +
                                            " & pid=$!; while ! ls " + (folder / "cache").string() +
                                            "/estimate-trajectory-*.sla >/dev/null 2>&1; do sleep "
                                            "0.05; done; kill -TERM $pid; wait $pid");
  EXPECT_EQ(stopped.status, 75) << stopped.err;
  EXPECT_NE(stopped.err.find("SL7001 interrupted"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder / "map.slmap"));
  const ProgramResult resumed = run_successfully(command + " --explain");
  EXPECT_NE(resumed.err.find("kept  estimate-trajectory: unchanged"), std::string::npos);
  EXPECT_TRUE(bytes_of(folder / "map.slmap") == bytes_of(compiled_map()));
}

std::vector<double> dumped(const std::string& target_and_flags, const std::string& what,
                           const std::string& column) {
  const ProgramResult run =
      run_successfully("dump " + target_and_flags + " --what " + what + " --format json");
  const nlohmann::json table = nlohmann::json::parse(run.out);
  const std::vector<std::string> columns = table.at("columns");
  const auto index = static_cast<std::size_t>(std::ranges::find(columns, column) - columns.begin());
  std::vector<double> values;
  for (const nlohmann::json& row : table.at("rows")) values.push_back(row.at(index));
  return values;
}

TEST(Compile, MappingErrorIsWhatTheMapsOwnScansFindWhenTheyAreLocalized) {
  compiled_map();
  const std::vector<double> mapping_error_m = dumped(config(), "factors", "mapping_error");
  EXPECT_EQ(mapping_error_m, dumped(config(), "own/measured", "from_given_m"));
  // As a drive that judges, whose starts share nothing. The mapping recording itself would be the
  // split: one scan of the copy ends in another byte.
  const std::filesystem::path copy = fresh_folder() / "mapping";
  std::filesystem::copy(small_town() / "mapping", copy, std::filesystem::copy_options::recursive);
  std::ofstream(copy / "scans" / "000000.pcd", std::ios::app) << '\n';
  const std::string folder = copy.string();
  const std::vector<double> judged_m =
      dumped(config() + " --set localization.scans=" + folder +
                 "/scans --set localization.poses=" + folder + "/poses.tum",
             "measured", "mean_m");
  ASSERT_EQ(mapping_error_m.size(), judged_m.size());
  for (std::size_t row = 0; row < judged_m.size(); ++row) {
    EXPECT_NEAR(mapping_error_m[row], judged_m[row], 0.005) << "row " << row;
  }
  EXPECT_NE(mapping_error_m, dumped(config(), "factors", "virtual_error"));
}

TEST(Compile, AModelThatLearnsFromASplitDriveIsToldNoMappingErrorOneMadeElsewhereIs) {
  const std::string split = config() + " --set localization.scans= --set localization.poses=";
  const std::vector<double> learnt_m = dumped(split, "factors", "mapping_error");
  EXPECT_FALSE(learnt_m.empty());
  EXPECT_EQ(learnt_m, dumped(split, "factors", "virtual_error"));
  EXPECT_NE(learnt_m, dumped(split, "factors", "own_error")) << "what the choice is held against";
  const std::string map = (fresh_folder() / "split.slmap").string();
  run_successfully("compile " + split + " -q --model " + compiled_map().string() + " -o " + map);
  EXPECT_NE(dumped(map, "factors", "mapping_error"), dumped(map, "factors", "virtual_error"));
  run_successfully("verify --deep " + map);
  // No drive is named that judges.
  const ProgramResult judged =
      run_successfully("evaluate " + split + " --map " + map + " --set evaluation.scans= -j 2");
  EXPECT_NE(judged.out.find("On its own drive (same drive, other scans: optimistic)"),
            std::string::npos)
      << judged.out;
  EXPECT_NE(judged.err.find("the scans of the mapping drive that did not make the map"),
            std::string::npos)
      << judged.err;
}

TEST(Compile, OnAFullDiskLeavesNoMap) {
  const std::filesystem::path folder = fresh_folder();
  compiled_map();
  // A limit on the size of files, which the kernel reports in the same place as a full disk.
  const ProgramResult full =
      run_command("trap '' XFSZ; ulimit -f 64; " + std::string(SIGHTLINE_PROGRAM) + " compile " +
                  config() + " -q -o " + (folder / "map.slmap").string());
  EXPECT_EQ(full.status, 74) << full.err;
  EXPECT_TRUE(std::filesystem::is_empty(folder));
}

TEST(Verify, AcceptsTheMapAndRefusesADamagedOne) {
  const std::filesystem::path folder = fresh_folder();
  run_successfully("verify " + compiled_map().string());
  std::string bytes = bytes_of(compiled_map());
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  ASSERT_TRUE(write_file_atomically(folder / "bad.slmap", bytes, IfExists::kRefuse));
  const ProgramResult damaged = run_sightline("verify " + (folder / "bad.slmap").string());
  EXPECT_EQ(damaged.status, 67) << damaged.err;
  bytes.resize(bytes.size() / 2);
  ASSERT_TRUE(write_file_atomically(folder / "cut.slmap", bytes, IfExists::kRefuse));
  EXPECT_EQ(run_sightline("inspect " + (folder / "cut.slmap").string()).status, 67);
}

TEST(Verify, ProvesTheAnnotationFromTheMapAlone) {
  const ProgramResult run = run_successfully("verify --deep " + compiled_map().string());
  EXPECT_NE(run.out.find("sites verified"), std::string::npos) << run.out;
}

TEST(Verify, SaysOnOneLineWhatWasChecked) {
  const ProgramResult run = run_successfully("verify " + compiled_map().string());
  EXPECT_EQ(lines_of(run.out).size(), 1U) << run.out;
  EXPECT_NE(run.out.find("checked every digest, checksum, bound and order"), std::string::npos);
  EXPECT_NE(run_successfully("verify --tables " + compiled_map().string()).out.find("manifest"),
            std::string::npos);
  const nlohmann::json json = nlohmann::json::parse(
      run_successfully("verify --format json " + compiled_map().string()).out);
  EXPECT_EQ(schema_faults(schema("verify"), json), "");
}

TEST(Inspect, FitsOnAScreenAndGivesTheVerdict) {
  const ProgramResult run = run_successfully("inspect " + compiled_map().string());
  EXPECT_EQ(run.out.rfind("Verdict: ", 0), 0U) << run.out;
  expect_lines(run.out.substr(0, run.out.find("\nNext: ")), 40);
  EXPECT_LE(lines_of(run.out).size(), 40U) << run.out;
  const nlohmann::json json = nlohmann::json::parse(
      run_successfully("inspect --format json " + compiled_map().string()).out);
  EXPECT_EQ(schema_faults(schema("inspect"), json), "");
  EXPECT_EQ(run.out.rfind("Verdict: " + json.at("verdict").at("word").get<std::string>(), 0), 0U);
}

TEST(Inspect, SaysSitesRangesPromiseAndModel) {
  const ProgramResult run = run_successfully("inspect --all " + compiled_map().string());
  for (const char* word : {"sites", "0.1 m", "0.25 m", "coverage", "tree_count", "R^2 at 10 m"}) {
    EXPECT_NE(run.out.find(word), std::string::npos) << word << " in\n" << run.out;
  }
}

TEST(Train, ItsModelNamesTheRecordingsItWasTrainedOn) {
  const std::string model = (fresh_folder() / "town.slmodel").string();
  const ProgramResult trained =
      run_successfully("train " + config() + " -q --with-evaluation -o " + model);
  const auto recordings = [](const std::string& target) {
    const ProgramResult run =
        run_successfully("dump " + target + " --what recordings --format csv");
    return run.out;
  };
  std::istringstream rows(recordings(config()));
  std::string row;
  ASSERT_TRUE(std::getline(rows, row));
  std::string expected = "place," + row + "\n";
  while (std::getline(rows, row)) expected += "town.yaml," + row + "\n";
  EXPECT_EQ(std::ranges::count(expected, '\n'), 4) << "three drives below a heading";
  EXPECT_EQ(recordings(model), expected);
  const nlohmann::json json = nlohmann::json::parse(
      run_successfully("train " + config() + " --with-evaluation --force --format json -o " + model)
          .out);
  EXPECT_EQ(schema_faults(schema("inspect"), json), "");
  const ProgramResult inspected = run_sightline("inspect " + model);
  EXPECT_NE(inspected.out.find("Recordings that it was trained on"), std::string::npos);
}

TEST(Compile, PrintsAndStopsAfterAPassWithoutAMap) {
  compiled_map();
  const ProgramResult run = run_successfully(
      "compile -q --set build-ndt.cell_m=2 --print-after build-ndt --stop-after build-ndt " +
      config());
  EXPECT_NE(run.out.find("mean_x_m"), std::string::npos);
  EXPECT_EQ(run.out.find("Table I."), std::string::npos);
}

TEST(Dump, PrintsEveryTableInEveryFormat) {
  compiled_map();
  for (const char* what : {"nds", "sites", "factors", "measured", "predicted", "ranges",
                           "trajectory", "model", "evaluation"}) {
    for (const char* format : {"csv", "json", "text"}) {
      const ProgramResult run =
          run_successfully("dump " + config() + " -q --what " + what + " --format " + format);
      EXPECT_GT(run.out.size(), 100U) << what;
    }
  }
  const ProgramResult depth =
      run_successfully("dump " + config() + " -q --what depth --site 3 --format csv");
  const ProgramResult picture =
      run_successfully("dump " + config() + " -q --what depth --site 3 --format png");
  EXPECT_EQ(picture.out.substr(1, 3), "PNG");
}

TEST(Dump, SaysTheSameOfTheMapAsOfTheArtifact) {
  for (const char* what : {"sites", "predicted", "ranges"}) {
    const std::string table = std::string(" -q --format csv --what ") + what;
    const ProgramResult map = run_sightline("dump " + compiled_map().string() + table);
    const ProgramResult artifact = run_sightline("dump " + config() + table);
    ASSERT_EQ(map.status, 0) << map.err;
    EXPECT_TRUE(map.out == artifact.out) << what;
  }
}

TEST(Evaluate, JudgesByAnotherDriveAndWritesItsTables) {
  const std::filesystem::path folder = fresh_folder();
  const ProgramResult run = run_successfully(
      "evaluate " + config() + " --map " + compiled_map().string() + " --json " +
      (folder / "e.json").string() + " --csv " + (folder / "e.csv").string() + " --tables");
  for (const char* word : {"Table I.", "Table II.", "oracle", "coverage", "by kind of place",
                           "Calibration", "Continuous localization"}) {
    EXPECT_NE(run.out.find(word), std::string::npos) << word << " in\n" << run.out;
  }
  EXPECT_EQ(fault_of_evaluation(bytes_of(folder / "e.json")), "");
  EXPECT_GT(bytes_of(folder / "e.csv").size(), 500U);
}

// The verdict by the evaluation is the same in every verb that has it.
TEST(Evaluate, PrintsTwelveLinesAndItsVerdictIsThatOfInspectGateAndReport) {
  const std::filesystem::path folder = fresh_folder();
  const std::string map = compiled_map().string();
  const std::string file = (folder / "evaluation.json").string();
  const ProgramResult run = run_successfully("evaluate " + config() + " --map " + map);
  EXPECT_LE(lines_of(run.out).size(), 12U) << run.out;
  EXPECT_NE(run.out.find("best fixed choice"), std::string::npos) << run.out;
  EXPECT_EQ(run_successfully("evaluate " + config() + " -q --map " + map + " -o " + file).out, "");
  EXPECT_EQ(fault_of_evaluation(bytes_of(file)), "");
  // Times of two evaluations differ; the verdict, which does not contain any, does not.
  const std::string first = run.out.substr(0, run.out.find("\nNext: "));
  const std::string evaluation = map + " --evaluation " + file;
  EXPECT_EQ(run_successfully("inspect " + evaluation).out.rfind(first, 0), 0U) << first;
  const ProgramResult gate = run_sightline("gate " + evaluation);
  EXPECT_EQ(gate.out.rfind(first, 0), 0U) << gate.out;
  EXPECT_LE(lines_of(gate.out).size(), 12U) << gate.out;
  const std::string page = (folder / "town.html").string();
  const ProgramResult report = run_successfully("report " + evaluation + " -o " + page);
  expect_summary(report.out, page);
  EXPECT_NE(report.out.find("\n" + first), std::string::npos) << report.out;
}

std::string evaluating(const std::string& drive) {
  const std::filesystem::path folder = small_town() / drive;
  return "evaluate " + config() + " --map " + compiled_map().string() +
         " --set evaluation.name=evening --set evaluation.scans=" + (folder / "scans").string() +
         " --set evaluation.poses=" + (folder / "poses.tum").string();
}

// drive_1 was localized in the map; both under another name.
TEST(Evaluate, RefusesADriveThatTheMapOrItsErrorsWereMadeFrom) {
  for (const std::string drive : {"mapping", "drive_1"}) {
    const ProgramResult run = run_sightline(evaluating(drive));
    EXPECT_EQ(run.status, 65) << run.err;
    EXPECT_NE(run.err.find("SL2029 known-drive"), std::string::npos) << run.err;
    EXPECT_NE(run.err.find("--allow-known-drive"), std::string::npos) << run.err;
    EXPECT_EQ(run.out, "") << "nothing is judged";
  }
}

TEST(Evaluate, RefusesADriveThatTheModelOfTheMapWasTrainedOn) {
  const std::filesystem::path folder = fresh_folder();
  const std::string model = (folder / "with.slmodel").string();
  const std::string map = (folder / "town.slmap").string();
  run_successfully("train " + config() + " -q --with-evaluation -o " + model);
  run_successfully("compile " + config() + " -q --model " + model + " -o " + map);
  const ProgramResult run = run_sightline("evaluate " + config() + " --map " + map);
  EXPECT_EQ(run.status, 65) << run.err;
  EXPECT_NE(run.err.find("on which the map's model was trained"), std::string::npos) << run.err;
}

TEST(Evaluate, MarksAKnownDriveInEveryOutput) {
  const std::filesystem::path file = fresh_folder() / "known.json";
  const std::string map = compiled_map().string();
  const ProgramResult run =
      run_successfully(evaluating("drive_1") + " --allow-known-drive --json " + file.string());
  EXPECT_NE(run.out.find("(known drive: optimistic)"), std::string::npos) << run.out;
  EXPECT_EQ(fault_of_evaluation(bytes_of(file)), "");
  EXPECT_NE(bytes_of(file).find("drive_role"), std::string::npos);
  const std::string evaluation = map + " --evaluation " + file.string();
  const ProgramResult inspected = run_successfully("inspect " + evaluation);
  EXPECT_NE(inspected.out.find("(known drive: optimistic)"), std::string::npos) << inspected.out;
  const nlohmann::json gate =
      nlohmann::json::parse(run_sightline("gate " + evaluation + " --format json").out);
  for (const nlohmann::json& check : gate.at("checks")) {
    if (check.at("rule").get<std::string>().starts_with("observed-")) {
      EXPECT_EQ(check.at("verdict"), "not-judged") << check;
    }
  }
}

TEST(Compile, PrintsTablesAndJsonByTheirFlags) {
  const std::string map = (fresh_folder() / "town.slmap").string();
  const std::string compile = "compile " + config() + " -q -o " + map;
  compiled_map();
  EXPECT_EQ(run_successfully(compile).out, "");
  const std::string again = "compile " + config() + " --force -o " + map;
  EXPECT_NE(run_successfully(again + " --tables").out.find("Table I."), std::string::npos);
  const nlohmann::json json = nlohmann::json::parse(run_successfully(again + " --format json").out);
  EXPECT_EQ(schema_faults(schema("inspect"), json), "");
}

TEST(Compile, EstimatesItsCostAsJson) {
  const ProgramResult run =
      run_successfully("compile " + config() + " --dry-run --format json --no-cache");
  const nlohmann::json json = nlohmann::json::parse(run.out);
  EXPECT_EQ(schema_faults(schema("cost"), json), "");
  EXPECT_GT(json.at("steps").size(), 10U);
}

TEST(Version, IsPrintedAsJsonToo) {
  const nlohmann::json json =
      nlohmann::json::parse(run_successfully("--version --format json").out);
  EXPECT_EQ(schema_faults(schema("version"), json), "");
  const std::string text = run_successfully("--version").out;
  EXPECT_NE(text.find(json.at("commit").get<std::string>()), std::string::npos);
  EXPECT_EQ(run_sightline("--version --format yaml").status, 64);
}

TEST(Admit, PrintsReleaseAndRootAsJson) {
  const std::string in = fresh_folder().string() + "/";
  run_successfully("fleet key " + in + "a");
  run_successfully("fleet root --fleet metropolis --signer " + in + "a.pub --threshold 1 -o " + in +
                   "root.1");
  run_successfully("fleet root --previous " + in + "root.1 --signer " + in +
                   "a.pub --threshold 1 -o " + in + "root.2");
  run_successfully("fleet release " + compiled_map().string() +
                   " --fleet metropolis --counter 1 -o " + in + "release");
  for (const char* record : {"root.2", "release"}) {
    run_successfully("fleet sign " + in + record + " --key " + in + "a.key");
  }
  const std::string admit = "fleet admit --root " + in + "root.1 --format json ";
  const nlohmann::json root =
      nlohmann::json::parse(run_successfully(admit + "--next-root " + in + "root.2").out);
  EXPECT_EQ(schema_faults(schema("admit"), root), "");
  EXPECT_EQ(root.at("root").at("version"), 2);
  const std::string file = in + "admitted.json";
  run_successfully(admit + in + "release -o " + file);
  const nlohmann::json release = nlohmann::json::parse(bytes_of(file));
  EXPECT_EQ(schema_faults(schema("admit"), release), "");
  EXPECT_EQ(release.at("fetch").at("kind"), "map");
  const nlohmann::json present = nlohmann::json::parse(
      run_successfully(admit + in + "release --present " + compiled_map().string()).out);
  EXPECT_EQ(present.at("fetch").at("file"), nullptr) << present;
}

TEST(Evaluate, AddsWorldCoordinatesToEveryPlace) {
  const std::filesystem::path file = fresh_folder() / "e.json";
  run_successfully("evaluate " + config() + " -q --map " + compiled_map().string() + " --json " +
                   file.string());
  const nlohmann::json facts =
      nlohmann::json::parse(
          run_successfully("dump " + compiled_map().string() + " --what sites --format json").out)
          .at("facts");
  std::size_t places = 0;
  for (const nlohmann::json& table : nlohmann::json::parse(bytes_of(file))) {
    const std::vector<std::string> columns = table.at("columns");
    const auto cell = [&](const nlohmann::json& row, const std::string& column) {
      const auto index = std::ranges::find(columns, column) - columns.begin();
      return row.at(static_cast<std::size_t>(index)).get<double>();
    };
    if (std::ranges::find(columns, "p_x_m") == columns.end()) continue;
    for (const nlohmann::json& row : table.at("rows")) {
      ++places;
      for (const std::string axis : {"x", "y"}) {
        EXPECT_EQ(
            cell(row, "p_" + axis + "_world_m"),
            cell(row, "p_" + axis + "_m") + facts.at("origin_world_" + axis + "_m").get<double>());
      }
    }
  }
  EXPECT_GT(places, 300U);
}

TEST(VehicleReader, FollowsADriveThroughTheMap) {
  const ProgramResult run =
      run_command(std::string(SIGHTLINE_VEHICLE_READER) + " " + compiled_map().string() + " " +
                  (small_town() / "drive_2" / "poses.tum").string());
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_GT(std::count(run.out.begin(), run.out.end(), '\n'), 100);
}

std::string csv_of_measured() {
  const ProgramResult run =
      run_successfully("dump " + config() + " -q --what measured --format json");
  const nlohmann::json table = nlohmann::json::parse(run.out);
  std::map<std::string, std::size_t> column;
  for (const std::string name : table.at("columns")) column.emplace(name, column.size());
  std::map<std::pair<int, double>, double> errors_m;
  for (const nlohmann::json& row : table.at("rows")) {
    if (row.at(column["scan"]) < 0) continue;
    errors_m[{row.at(column["scan"]), row.at(column["range_m"])}] = row.at(column["mean_m"]);
  }
  std::ostringstream csv;
  csv.precision(17);
  csv << "scan,look,start,error\n";
  for (const auto& [of, error_m] : errors_m) {
    csv << of.first << "," << of.second << ",0," << error_m << "\n";
  }
  return csv.str();
}

TEST(ImportErrors, MakeAMapForTheLocalizerThatMadeThemAndForNoOther) {
  compiled_map();
  const std::filesystem::path folder = fresh_folder();
  const std::string file = (folder / "errors.csv").string();
  ASSERT_TRUE(write_file_atomically(file, csv_of_measured(), IfExists::kRefuse));
  const std::string imports =
      config() + " --set import-errors.file=" + file +
      " --set import-errors.localizer=my-ndt --set import-errors.version=2 ";
  EXPECT_EQ(dumped(imports, "measured", "mean_m"), dumped(config(), "measured", "mean_m"));
  const std::string map = (folder / "town.slmap").string();
  const ProgramResult compiled = run_successfully("compile " + imports + "-o " + map);
  EXPECT_EQ(compiled.out.rfind("Wrote " + map, 0), 0U) << compiled.out;
  EXPECT_EQ(dumped(map, "predicted", "mean_error_m"),
            dumped(compiled_map().string(), "predicted", "mean_error_m"))
      << "the same errors teach the same";
  const ProgramResult inspected = run_sightline("inspect --all " + map);
  EXPECT_NE(inspected.out.find("my-ndt v2: ranges and probabilities are for it alone"),
            std::string::npos)
      << inspected.out;
  const ProgramResult listed = run_sightline("compile " + imports + "--list-inputs");
  EXPECT_NE(listed.out.find(file), std::string::npos);
  for (const auto& [localizer, is_known] :
       {std::pair("my-ndt/2", true), std::pair("my-ndt/1", false), std::pair("searching", false)}) {
    const ProgramResult read =
        run_command(std::string(SIGHTLINE_VEHICLE_READER) + " " + map + " " +
                    (small_town() / "drive_2" / "poses.tum").string() + " 0.25 " + localizer);
    EXPECT_EQ(read.status, 0) << read.err;
    EXPECT_EQ(read.out.find("unknown-localizer") == std::string::npos, is_known) << localizer;
    EXPECT_EQ(read.out.find(" nan ") == std::string::npos, is_known) << localizer;
  }
}

TEST(ImportErrors, AreRefusedAtTheLineThatIsWrong) {
  const std::filesystem::path folder = fresh_folder();
  const std::string file = (folder / "errors.csv").string();
  const auto refused = [&](const std::string& csv, const std::string& message) {
    EXPECT_TRUE(write_file_atomically(file, csv, IfExists::kReplace));
    const ProgramResult run =
        run_sightline("compile " + config() + " -q -o " + (folder / "map.slmap").string() +
                      " --set import-errors.file=" + file + " --set import-errors.localizer=a");
    EXPECT_EQ(run.status, 65) << run.err;
    EXPECT_NE(run.err.find(message), std::string::npos) << run.err;
  };
  refused("scan,look,start\n", "SL2008 missing-field: " + file + " (line 1): no column error");
  refused("scan,look,start,error\n1,10,0,0.1\n1,10,1,x\n",
          "SL2020 malformed-text: " + file + " (line 3): found error 'x'");
  refused("scan,look,start,error\n99999,10,0,0.1\n", "SL2022 mismatched-inputs");
}

TEST(YourOwnPass, RunsOverTheMap) {
  const ProgramResult run =
      run_command(std::string(SIGHTLINE_YOUR_OWN_PASS) + " " + compiled_map().string());
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(run.out.rfind("site,clearance_m\n", 0), 0U) << run.out;
  EXPECT_GT(std::count(run.out.begin(), run.out.end(), '\n'), 100);
}

TEST(Compile, NeedsTheNameOfItsOutput) {
  EXPECT_EQ(run_sightline("compile " + config()).status, 64);
}

}  // namespace
}  // namespace sightline
