#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "tests/support/json_schema.h"
#include "tests/support/value_of.h"
#include "tests/system/program.h"

// `sightline localize` in a generated town, by the plan of its map.

namespace sightline {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using Json = nlohmann::json;

std::string scans_folder() { return (compiled_town() / "drive_1/scans").string(); }
std::string truth_file() { return (compiled_town() / "drive_1/poses.tum").string(); }
std::string localize(const std::string& recording) {
  return "localize " + recording + " --map " + map_file() + " ";
}

Json json_of(const ProgramResult& run) { return Json::parse(run.out); }

std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

// A folder with links to the scans of the drive, of which some may be replaced.
std::vector<fs::path> link_scans(const fs::path& folder) {
  std::vector<fs::path> links;
  for (const fs::path& file : files_in(scans_folder())) {
    links.push_back(folder / file.filename());
    fs::create_symlink(file, links.back());
  }
  return links;
}

void replace_by(const fs::path& link, const std::string& bytes) {
  fs::remove(link);
  std::ofstream(link, std::ios::binary) << bytes;
}

TEST(Localize, FollowsADriveToCentimetres) {
  const fs::path folder = fresh_folder();
  const ProgramResult run = run_successfully(localize(config_file()) + "--compare " + truth_file() +
                                             " -o " + (folder / "poses.tum").string());
  EXPECT_THAT(run.out,
              AllOf(HasSubstr("Wrote "), HasSubstr("(100.0 %)"), HasSubstr("Lost       never\n")));
  const Json json = json_of(
      run_successfully(localize(config_file()) + "--format json --compare " + truth_file()));
  const Json schema =
      Json::parse(bytes_of(fs::path(SIGHTLINE_ROOT) / "schemas/localize.schema.json"));
  EXPECT_EQ(schema_faults(schema, json), "");
  EXPECT_EQ(json["localized"], json["scans"]);
  EXPECT_EQ(json["compared"]["pairs"], json["scans"]);
  EXPECT_LT(json["compared"]["absolute_m"]["rmse"], 0.05);
  EXPECT_LT(json["compared"]["absolute_m"]["max"], 0.25);
  EXPECT_LT(json["time"]["median_ms"], json["time"]["period_ms"]);
}

TEST(Localize, WritesTheSameBytesWithAnyNumberOfThreads) {
  const fs::path folder = fresh_folder();
  for (const std::string ending : {".tum", ".csv", ".mcap"}) {
    const fs::path one = folder / ("one" + ending);
    const fs::path four = folder / ("four" + ending);
    run_successfully(localize(config_file()) + "-q -j 1 -o " + one.string());
    run_successfully(localize(config_file()) + "-q -j 4 -o " + four.string());
    EXPECT_EQ(bytes_of(one), bytes_of(four)) << ending;
  }
}

// A scan that fits two places is no start: one of the next scans is.
TEST(Localize, SearchesTheWholeMapForAFolderWithoutPoses) {
  for (const std::string& command :
       {localize(scans_folder()), localize(config_file()) + "--from-nothing "}) {
    const Json json = json_of(run_successfully(command + "--format json"));
    EXPECT_GE(json["localized"].get<int>(), json["scans"].get<int>() - 5) << command;
    EXPECT_EQ(json["times_lost"], 0) << command;
  }
}

TEST(Localize, TakesABagOrFolderAloneWithAGivenStart) {
  const std::string folder = scans_folder();
  std::istringstream truth(bytes_of(truth_file()));
  std::string line;
  while (std::getline(truth, line) && line.starts_with('#')) {
  }
  std::istringstream words(line);
  double t = 0.0, x = 0.0, y = 0.0, z = 0.0, qx = 0.0, qy = 0.0, qz = 0.0, qw = 0.0;
  words >> t >> x >> y >> z >> qx >> qy >> qz >> qw;
  const double yaw_deg = 2.0 * std::atan2(qz, qw) * 180.0 / std::numbers::pi;
  const auto start = [&](double ahead_m) {
    std::ostringstream text;
    text << std::fixed << "--start " << x + ahead_m << " " << y << " " << z << " " << yaw_deg + 1.0;
    return text.str();
  };
  const Json json = json_of(run_successfully(localize(folder) + start(0.5) + " --format json"));
  EXPECT_EQ(json["localized"], json["scans"]);
  const ProgramResult far = run_sightline(localize(folder) + start(300.0));
  EXPECT_EQ(far.status, 65);
  EXPECT_THAT(far.err, HasSubstr("SL2016 no-overlap"));
  EXPECT_EQ(run_sightline(localize(folder) + "--start 1 2 3 north").status, 64);
}

TEST(Localize, RefusesADriveOfAnotherTown) {
  const fs::path folder = fresh_folder();
  const fs::path other = folder / "other";
  make_town(other, "--seed 8 --length-m 40 --drives 1 --origin-m 456500,5429500");
  const fs::path poses = folder / "poses.tum";
  const ProgramResult run =
      run_sightline(localize((other / "town.yaml").string()) + "-o " + poses.string());
  EXPECT_EQ(run.status, 65);
  EXPECT_THAT(run.err, HasSubstr("SL2016 no-overlap"));
  EXPECT_FALSE(fs::exists(poses));
}

TEST(Localize, LeavesOutScansThatAreDamagedOrEmpty) {
  const fs::path folder = fresh_folder();
  const std::vector<fs::path> scans = link_scans(folder);
  replace_by(scans[20], bytes_of(scans[20]).substr(0, 300));
  const std::string alone = localize(config_file()) + "--set localization.scans=" + folder.string();
  const ProgramResult run = run_successfully(alone + " --format json");
  EXPECT_THAT(run.err, HasSubstr("1 of " + std::to_string(scans.size()) + " scans cannot be read"));
  const Json json = json_of(run);
  EXPECT_EQ(json["skipped"], 1);
  EXPECT_EQ(json["localized"], scans.size() - 1);
}

TEST(Localize, SaysWhereItWasLostAndGoesOn) {
  const fs::path folder = fresh_folder();
  const fs::path other = folder / "other";
  make_town(other, "--seed 8 --length-m 40 --drives 1 --origin-m 456500,5429500");
  const std::vector<fs::path> elsewhere = files_in(other / "drive_1/scans");
  const fs::path drive = folder / "drive";
  fs::create_directory(drive);
  const std::vector<fs::path> scans = link_scans(drive);
  for (std::size_t i = 30; i < 55; ++i) replace_by(scans[i], bytes_of(elsewhere[i - 30]));
  const Json json = json_of(run_successfully(
      localize(config_file()) + "--format json --set localization.scans=" + drive.string()));
  EXPECT_EQ(json["times_lost"], 1);
  EXPECT_GE(json["lost"], 10);
  EXPECT_LE(json["lost"], 25);
  EXPECT_EQ(json["localized"].get<int>() + json["lost"].get<int>(), json["scans"].get<int>());
  for (const Json& stretch : json["stretches"]) {
    if (stretch["state"] != "lost") continue;
    EXPECT_GE(stretch["first_scan"], 30);
    EXPECT_EQ(stretch["last_scan"], 54);
  }
}

TEST(Localize, IsReadByTheModulesOfMcap) {
  const fs::path folder = fresh_folder();
  for (const char* name : {"poses.mcap", "poses.tum"}) {
    run_successfully(localize(config_file()) + "-q -o " + (folder / name).string());
  }
  const ProgramResult read =
      run_command(std::string(SIGHTLINE_ROOT) + "/tests/system/read_mcap.py " +
                  (folder / "poses.mcap").string() + " " + (folder / "poses.tum").string());
  if (read.status == 77) GTEST_SKIP() << read.out;
  EXPECT_EQ(read.status, 0) << read.err;
  EXPECT_THAT(read.out, HasSubstr("/sightline/pose "));
}

}  // namespace
}  // namespace sightline
