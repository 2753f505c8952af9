#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "formats/base/files/atomic_file.h"
#include "tests/system/program.h"

// A town is mapped by a drive, its points are exported, and the export is annotated without any
// drive: beside the map that the drives made, and judged by a third drive.

namespace sightline {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr const char* kFew =
    " --set measure-error.offset_count=3 --set train-model.trees=20 --set "
    "annotation.ranges_m=10,30";

struct AnnotatedTown {
  fs::path folder;
  ProgramResult annotated;

  [[nodiscard]] std::string file(const std::string& name) const { return (folder / name).string(); }
};

const AnnotatedTown& town() {
  static const AnnotatedTown kTown = [] {
    AnnotatedTown made;
    made.folder = small_town();
    run_successfully("compile " + made.file("town.yaml") + " -q -o " + made.file("town.slmap"));
    // In the recording's own coordinates, every point of it.
    run_successfully("export " + made.file("town.yaml") + " -q --format autoware --leaf 0 " +
                     "--world enu:48.98,8.39,0 -o " + made.file("points"));
    made.annotated = run_successfully("annotate " + made.file("points") + " --route " +
                                      made.file("mapping/poses.tum") + " --sensor generic-16 -o " +
                                      made.file("annotated.slmap") + kFew);
    return made;
  }();
  return kTown;
}

// Rows of `dump --format csv` by cell, facts left out.
std::map<std::vector<std::string>, std::map<std::string, double>> nds_of(const std::string& map) {
  const ProgramResult dumped = run_successfully("dump " + map + " --what nds --format csv -q");
  std::map<std::vector<std::string>, std::map<std::string, double>> nds;
  std::vector<std::string> columns;
  std::istringstream lines(dumped.out);
  std::map<std::string, double> origin_m;
  for (std::string line; std::getline(lines, line);) {
    std::vector<std::string> cells;
    std::istringstream words(line);
    if (line.starts_with("# ")) {
      const std::size_t colon = line.find(": ");
      origin_m[line.substr(2, colon - 2)] = std::strtod(line.c_str() + colon + 2, nullptr);
      continue;
    }
    for (std::string word; std::getline(words, word, ',');) cells.push_back(word);
    if (columns.empty()) {
      columns = cells;
      continue;
    }
    std::map<std::string, double> row;
    for (std::size_t i = 0; i < columns.size(); ++i) row[columns[i]] = std::stod(cells[i]);
    std::vector<std::string> key;
    for (const std::string axis : {"x", "y", "z"}) {
      row["mean_" + axis + "_m"] += origin_m.at("origin_world_" + axis + "_m");
      key.push_back(std::to_string(std::lround(
          std::floor(row["mean_" + axis + "_m"] / 2.0))));  // cells of 2 m, of the world
    }
    nds[key] = row;
  }
  return nds;
}

TEST(Annotate, NdsAreThoseOfTheDriveThatMadeThePoints) {
  const auto by_drive = nds_of(town().file("town.slmap"));
  const auto annotated = nds_of(town().file("annotated.slmap"));
  ASSERT_GT(by_drive.size(), 1000U);
  std::size_t near = 0;
  for (const auto& [cell, nd] : by_drive) {
    const auto found = annotated.find(cell);
    if (found == annotated.end()) continue;
    double off_m = 0.0;
    for (const std::string axis : {"x", "y", "z"}) {
      const std::string name = "mean_" + axis + "_m";
      off_m += std::abs(found->second.at(name) - nd.at(name));
    }
    near += off_m < 1e-3 ? 1 : 0;
  }
  RecordProperty("nds_by_drive", static_cast<int>(by_drive.size()));
  RecordProperty("nds_within_1_mm", static_cast<int>(near));
  // Coordinates of the export are floats: a point on a face may change its cell.
  EXPECT_GT(static_cast<double>(near), 0.99 * static_cast<double>(by_drive.size()));
}

TEST(Annotate, TheMapIsMarkedAsMadeWithoutADrive) {
  EXPECT_THAT(town().annotated.out, HasSubstr("Verdict: not judged. No drive has judged this map"));
  EXPECT_THAT(town().annotated.out, HasSubstr("No promise"));
  EXPECT_THAT(town().annotated.err, HasSubstr("no scan was recorded at"));
  const ProgramResult inspected =
      run_successfully("inspect --all " + town().file("annotated.slmap"));
  EXPECT_THAT(inspected.out, HasSubstr("100.0 % of sites: no scan was recorded there"));
  EXPECT_THAT(inspected.out, HasSubstr("no drive was here"));
  EXPECT_THAT(inspected.out, Not(HasSubstr("coverage measured")));
  EXPECT_THAT(inspected.out, Not(HasSubstr("coverage promised")));
  const ProgramResult site =
      run_sightline("inspect " + town().file("annotated.slmap") + " --site 20");
  EXPECT_THAT(site.out, HasSubstr("simulated: no scan was recorded here"));
  const ProgramResult by_drive = run_sightline("inspect --all " + town().file("town.slmap"));
  EXPECT_THAT(by_drive.out, Not(HasSubstr("no scan was recorded")));
  const ProgramResult read =
      run_command(std::string(SIGHTLINE_VEHICLE_READER) + " " + town().file("annotated.slmap") +
                  " " + town().file("drive_2/poses.tum"));
  EXPECT_EQ(read.status, 0) << read.err;
  EXPECT_THAT(read.out, HasSubstr("simulated"));
}

TEST(Annotate, IsProvenFromItsOwnNumbersAndTheSameForAnyNumberOfThreads) {
  run_successfully("verify " + town().file("annotated.slmap") + " --deep");
  ASSERT_TRUE(write_file_atomically(town().folder / "points.yaml",
                                    "annotation: {ranges_m: [10, 30]}\n"
                                    "map: {points: points, sensor: generic-16}\n"
                                    "route: {file: mapping/poses.tum}\n"
                                    "measure-error: {offset_count: 3}\ntrain-model: {trees: 20}\n",
                                    IfExists::kReplace));
  const ProgramResult again =
      run_successfully("compile " + town().file("points.yaml") + " -q --no-cache --threads 1 -o " +
                       town().file("again.slmap"));
  EXPECT_TRUE(*read_file(town().file("annotated.slmap")) == *read_file(town().file("again.slmap")));
}

// By the share of its sites that the third drive finds within 25 cm.
TEST(Annotate, AThirdDriveJudgesItNearlyAsItJudgesTheMapByDrives) {
  const auto coverage_of = [](const std::string& map) {
    const std::string json = town().file("evaluation.json");
    run_successfully("evaluate " + town().file("town.yaml") + " --map " + map +
                     " -q --force --json " + json);
    const nlohmann::json tables = nlohmann::json::parse(*read_text_file(json));
    for (const nlohmann::json& table : tables) {
      if (table["name"] != "evaluation") continue;
      const std::vector<std::string> columns = table["columns"];
      const auto column = [&](const std::string& name) {
        return static_cast<std::size_t>(std::ranges::find(columns, name) - columns.begin());
      };
      for (const nlohmann::json& row : table["rows"]) {
        if (row[column("rule")] == "map" && row[column("limit_m")] == 0.25) {
          return row[column("coverage")].get<double>();
        }
      }
    }
    ADD_FAILURE() << "no coverage in " << json;
    return 0.0;
  };
  const double by_drive = coverage_of(town().file("town.slmap"));
  const double annotated = coverage_of(town().file("annotated.slmap"));
  EXPECT_GT(by_drive, 0.85);
  EXPECT_GT(annotated, by_drive - 0.02);
}

TEST(Annotate, ADriveAddedLaterIsMeasuredWhereItPassed) {
  run_successfully("annotate " + town().file("points") + " --route " +
                   town().file("mapping/poses.tum") + " --sensor generic-16 -q -o " +
                   town().file("driven.slmap") + kFew +
                   " --set localization.scans=" + town().file("drive_1/scans") +
                   " --set localization.poses=" + town().file("drive_1/poses.tum") +
                   " --set measure-error.reference=known");
  const ProgramResult inspected = run_sightline("inspect --all " + town().file("driven.slmap"));
  EXPECT_THAT(inspected.out, HasSubstr("coverage measured"));
  EXPECT_THAT(inspected.out, Not(HasSubstr("100.0 % of sites: no scan")));
}

class BadMap : public testing::Test {
 protected:
  void expect_refused(const std::string& map, const std::string& route, int status,
                      const std::string& mention) const {
    const ProgramResult run =
        run_sightline("annotate " + map + " --route " + route +
                      " --sensor generic-16 -q --no-cache -o " + (folder_ / "out.slmap").string());
    EXPECT_EQ(run.status, status) << run.err;
    EXPECT_THAT(run.err, HasSubstr(mention));
    EXPECT_FALSE(fs::exists(folder_ / "out.slmap"));
  }
  std::string write(const std::string& name, const std::string& text) const {
    EXPECT_TRUE(write_file_atomically(folder_ / name, text, IfExists::kReplace));
    return (folder_ / name).string();
  }
  [[nodiscard]] std::string cloud(const std::string& name,
                                  const std::vector<std::array<double, 3>>& points) const {
    std::ostringstream text;
    text.precision(12);
    text << "VERSION 0.7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nCOUNT 1 1 1\nWIDTH "
         << points.size() << "\nHEIGHT 1\nPOINTS " << points.size() << "\nDATA ascii\n";
    for (const auto& [x, y, z] : points) text << x << ' ' << y << ' ' << z << '\n';
    return write(name, text.str());
  }
  fs::path folder_ = fresh_folder();
};

TEST_F(BadMap, RoutesThatAreNoneOrElsewhereAndPointsInDegrees) {
  const std::string points = town().file("points");
  expect_refused(points, write("far.csv", "x,y\n2000,0\n2010,0\n"), 65, "SL2016 no-overlap");
  expect_refused(points, write("words.csv", "x,y\n1,one\n"), 65, "SL2020 malformed-text");
  expect_refused(cloud("degrees.pcd", {{8.39, 48.98, 100.0}, {8.391, 48.981, 120.0}}),
                 write("lanes.csv", "x,y\n8.39,48.98\n8.391,48.98\n"), 65,
                 "SL2004 unsupported-format");
}

TEST_F(BadMap, AMapWithoutGround) {
  std::vector<std::array<double, 3>> wall;
  for (int i = 0; i < 200; ++i) {
    for (int k = 0; k < 60; ++k) wall.push_back({0.1 * i, 4.0 + 0.001 * (k % 7), 1.0 + 0.1 * k});
  }
  expect_refused(cloud("wall.pcd", wall), write("lanes.csv", "x,y\n2,0\n12,0\n"), 65,
                 "SL2026 no-ground");
}

TEST_F(BadMap, ASensorThatDoesNotExist) {
  const ProgramResult run = run_sightline(
      "annotate " + town().file("points") + " --route " + town().file("mapping/poses.tum") +
      " --sensor generic-17 -q -o " + (folder_ / "out.slmap").string());
  EXPECT_EQ(run.status, 64);
  EXPECT_THAT(run.err, HasSubstr("generic-16"));
}

}  // namespace
}  // namespace sightline
