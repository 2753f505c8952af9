#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "formats/base/files/atomic_file.h"
#include "tests/support/real_data.h"
#include "tests/system/program.h"

// Recordings of real vehicles (tests/README.md); skipped where the one that is needed is missing.

namespace sightline {
namespace {

namespace fs = std::filesystem;

class RealDrive : public ::testing::Test {
 protected:
  void SetUp() override { folder_ = fresh_folder(); }
  ProgramResult compile(const std::string& yaml, const std::string& flags = "") const {
    EXPECT_TRUE(write_file_atomically(folder_ / "drive.yaml", yaml, IfExists::kReplace));
    return run_sightline("compile " + (folder_ / "drive.yaml").string() + " -q " + flags + " -o " +
                         (folder_ / "drive.slmap").string());
  }
  std::string town_model() const {
    run_successfully("compile " + (small_town() / "town.yaml").string() + " -q -o " +
                     (folder_ / "town.slmap").string() + " --set annotation.ranges_m=10,30");
    return "--model " + (folder_ / "town.slmap").string() + " --set annotation.ranges_m=10,30";
  }
  fs::path folder_;
};

TEST_F(RealDrive, WithoutPosesIsEstimatedMappedAndAnnotated) {
  const RealData data = real_data("kitti_0005");
  if (!data.missing.empty()) GTEST_SKIP() << data.missing;
  const ProgramResult run = compile("mapping: {scans: " + data.folder.string() +
                                    ", sensor: hdl-64e, poses_of: sensor}\n"
                                    "annotation: {model: own}\n");
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.err.find("too short"), std::string::npos) << "71 m promise nothing";
  const ProgramResult inspected =
      run_successfully("inspect --all " + (folder_ / "drive.slmap").string());
  for (const char* word : {"sites                  71", "limit 0.1 m", "limit 0.25 m", "coverage",
                           "error model", "none: figures of this drive"}) {
    EXPECT_NE(inspected.out.find(word), std::string::npos) << word << " in\n" << inspected.out;
  }
}

std::vector<std::array<double, 3>> positions_of(const fs::path& config, const std::string& what) {
  const ProgramResult run =
      run_successfully("dump " + config.string() + " -q --format json --what " + what);
  const nlohmann::json table = nlohmann::json::parse(run.out);
  const std::vector<std::string> columns = table.at("columns");
  const auto x = static_cast<std::size_t>(std::ranges::find(columns, "x_m") - columns.begin());
  std::vector<std::array<double, 3>> positions_m;
  for (const nlohmann::json& row : table.at("rows")) {
    positions_m.push_back({row.at(x), row.at(x + 1), row.at(x + 2)});
  }
  return positions_m;
}

// Its scans are drawn out by the vehicle's motion, and no file says so: laid into the map as they
// are they lie up to 17 cm from where they were.
TEST_F(RealDrive, WithoutPosesLiesInItsOwnMapWhereItMadeIt) {
  const RealData data = real_data("kitti_0005");
  if (!data.missing.empty()) GTEST_SKIP() << data.missing;
  // All scans but the last: the same recording would be split.
  const fs::path driven = folder_ / "driven";
  fs::create_directories(driven);
  for (const fs::directory_entry& scan : fs::directory_iterator(data.folder)) {
    const fs::path name = scan.path().filename();
    if (name != "0000000153.pcd") fs::create_symlink(scan.path(), driven / name);
  }
  const auto drive = [](const fs::path& scans) {
    return "{scans: " + scans.string() + ", sensor: hdl-64e, poses_of: sensor}\n";
  };
  const fs::path config = folder_ / "drive.yaml";
  ASSERT_TRUE(write_file_atomically(
      config, "mapping: " + drive(data.folder) + "localization: " + drive(driven),
      IfExists::kReplace));
  const auto made_m = positions_of(config, "trajectory");
  const auto found_m = positions_of(config, "localization/aligned");
  ASSERT_EQ(made_m.size(), 154U);
  ASSERT_EQ(found_m.size(), 153U);
  for (std::size_t i = 0; i < found_m.size(); ++i) {
    const double off_m = std::hypot(made_m[i][0] - found_m[i][0], made_m[i][1] - found_m[i][1],
                                    made_m[i][2] - found_m[i][2]);
    EXPECT_LT(off_m, 0.03) << "scan " << i;
  }
}

TEST_F(RealDrive, TooShortToTrainOnTakesItsOwnStaticAnswerOrAModelTrainedElsewhere) {
  const RealData data = real_data("mulran_kaist03");
  if (!data.missing.empty()) GTEST_SKIP() << data.missing;
  const fs::path mulran = data.folder / "mulran_kaist03";
  const std::string yaml = "mapping: {scans: " + (mulran / "Scans").string() +
                           ", poses: " + (mulran / "optimized_poses.txt").string() +
                           ", sensor: os1-64, poses_of: sensor}\n";
  const ProgramResult alone = compile(yaml + "annotation: {model: own}\n");
  EXPECT_EQ(alone.status, 0) << alone.err;
  EXPECT_NE(alone.err.find("too little data to train on"), std::string::npos) << alone.err;
  const ProgramResult inspected =
      run_sightline("inspect --all " + (folder_ / "drive.slmap").string());
  EXPECT_NE(inspected.out.find("the drive is too short to train on"), std::string::npos)
      << inspected.out;
  const ProgramResult run = compile(yaml, town_model() + " --force");
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(run.err.find("of the model's training sites"), std::string::npos)
      << "both begin at 0: " << run.err;
}

TEST_F(RealDrive, AtUtmCoordinatesKeepsItsMillimetres) {
  const RealData data = real_data("apollo_sunnyvale_ndt");
  if (!data.missing.empty()) GTEST_SKIP() << data.missing;
  const fs::path apollo = data.folder / "test_data" / "pcds";
  const ProgramResult run = compile("mapping: {scans: " + apollo.string() +
                                        ", poses: " + (apollo / "poses.txt").string() +
                                        ", sensor: hdl-64e, poses_of: sensor}\n",
                                    town_model());
  ASSERT_EQ(run.status, 0) << run.err;
  const ProgramResult dumped = run_successfully("dump " + (folder_ / "drive.yaml").string() +
                                                " -q --what trajectory --format csv");
  // World 588348.947978 = origin 588288 + 60.947978.
  EXPECT_NE(dumped.out.find("588288"), std::string::npos) << dumped.out;
  EXPECT_NE(dumped.out.find("60.947978"), std::string::npos) << dumped.out;
}

}  // namespace
}  // namespace sightline
