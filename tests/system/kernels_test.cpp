#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <sstream>
#include <string>
#include <vector>

#include "tests/system/program.h"

// A whole map, compiled with each version of the matcher's inner loop and interrupted in the middle
// of measuring: its bytes stay the same.

namespace sightline {
namespace {

// A shorter town than the other tests', for these compile it again and again.
std::filesystem::path short_town(const std::filesystem::path& folder,
                                 const std::string& size = "--length-m 40") {
  make_town(folder / "town", "--seed 3 " + size + " --drives 1");
  return folder / "town";
}

ProgramResult compile(const std::filesystem::path& town, const std::filesystem::path& map,
                      const std::string& flags) {
  return run_sightline("compile " + (town / "town.yaml").string() + " -q -o " + map.string() + " " +
                       flags);
}

TEST(Kernels, EachVersionCompilesTheSameMapWithAnyNumberOfThreads) {
  const std::filesystem::path folder = fresh_folder();
  // The portable version takes ten times as long to follow a drive.
  const std::filesystem::path town = short_town(folder, "--length-m 30 --spacing-m 2");
  ASSERT_EQ(compile(town, folder / "fastest.slmap", "--no-cache --threads 2").status, 0);
  const std::string expected = bytes_of(folder / "fastest.slmap");
  ASSERT_GT(expected.size(), 10'000U);
  int threads = 0;
  for (const std::string kernel : {"portable", "avx2", "avx512"}) {
    const std::filesystem::path map = folder / (kernel + ".slmap");
    const ProgramResult run = compile(
        town, map,
        "--no-cache --kernel " + kernel + " --threads " + std::to_string(1 + threads++ % 2));
    if (run.status == 64) continue;  // this processor does not have it
    ASSERT_EQ(run.status, 0) << run.err;
    EXPECT_TRUE(bytes_of(map) == expected) << kernel;
  }
  EXPECT_GE(threads, 1);
}

TEST(Kernels, KilledWhileItMeasuresACompileGoesOnFromThere) {
  const std::filesystem::path folder = fresh_folder();
  const std::filesystem::path town = short_town(folder);
  const std::string more = "--threads 1 --set measure-error.offset_count=40 ";
  const std::string cache = more + "--cache " + (folder / "cache").string();
  const std::string parts = (folder / "cache").string() + "/measure-error.parts";
  ASSERT_EQ(compile(town, folder / "whole.slmap", more + "--no-cache").status, 0);
  const ProgramResult killed = run_command(
      std::string(SIGHTLINE_PROGRAM) + " compile " + (town / "town.yaml").string() + " -q " +
      cache + " -o " + (folder / "map.slmap").string() + " & pid=$!; while [ $(ls " + parts +
      " 2>/dev/null | wc -l) -lt 2 ]; do sleep 0.01; done; kill -KILL $pid; wait $pid");
  EXPECT_EQ(killed.status, 137) << killed.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "map.slmap"));
  // A part that was kept is not made again: its file stays the same.
  const ProgramResult resumed = run_command(
      "cd " + folder.string() + " && first=" + parts + "/$(ls " + parts +
      " | head -1) && before=$(stat -c %i.%Y $first) && " + std::string(SIGHTLINE_PROGRAM) +
      " compile " + (town / "town.yaml").string() + " -q " + cache + " -o " +
      (folder / "map.slmap").string() + " && test $before = $(stat -c %i.%Y $first)");
  ASSERT_EQ(resumed.status, 0) << resumed.err;
  EXPECT_TRUE(bytes_of(folder / "map.slmap") == bytes_of(folder / "whole.slmap"));
}

TEST(Kernels, AVehicleLocalizesAScanInTheMap) {
  const std::filesystem::path folder = fresh_folder();
  const std::filesystem::path town = short_town(folder);
  // So few sites promise nothing: ranges are asked for that are nearly sure to be enough.
  const std::string sure =
      "--set choose-ranges.risk_control=fixed --set choose-ranges.probability_threshold=0.95";
  ASSERT_EQ(compile(town, folder / "map.slmap", sure).status, 0);
  std::string line, time;
  std::ifstream poses(town / "drive_1" / "poses.tum");
  while (std::getline(poses, line) && line[0] == '#') {
  }
  for (int skipped = 0; skipped < 40; ++skipped) std::getline(poses, line);
  double x = 0.0, y = 0.0, z = 0.0, qx = 0.0, qy = 0.0, qz = 0.0, qw = 1.0;
  std::istringstream(line) >> time >> x >> y >> z >> qx >> qy >> qz >> qw;
  const double yaw_deg = 2.0 * std::atan2(qz, qw) * 180.0 / 3.14159265358979;
  std::vector<std::filesystem::path> scans;
  for (const auto& entry : std::filesystem::directory_iterator(town / "drive_1" / "scans")) {
    scans.push_back(entry.path());
  }
  std::sort(scans.begin(), scans.end());
  const auto localize = [&](double x_m, double z_m) {
    std::ostringstream command;
    command << std::setprecision(15) << SIGHTLINE_VEHICLE_LOCALIZER << " "
            << (folder / "map.slmap").string() << " " << scans[40].string() << " " << x_m << " "
            << y + 0.3 << " " << z_m << " " << yaw_deg + 1.0;
    return run_command(command.str());
  };
  const ProgramResult run = localize(x + 0.4, z);
  ASSERT_EQ(run.status, 0) << run.err << run.out;
  const std::size_t found = run.out.find("position_world_m ");
  ASSERT_NE(found, std::string::npos) << run.out;
  double found_x = 0.0, found_y = 0.0, found_z = 0.0;
  std::istringstream(run.out.substr(found + 17)) >> found_x >> found_y >> found_z;
  EXPECT_LT(std::hypot(found_x - x, found_y - y, found_z - z), 0.25) << run.out;
  EXPECT_NE(run.out.find("stop converged"), std::string::npos) << run.out;
  const ProgramResult above = localize(x, z + 500.0);
  EXPECT_EQ(above.status, 1) << above.out;
  EXPECT_NE(above.out.find("stop no overlap"), std::string::npos) << above.out;
}

}  // namespace
}  // namespace sightline
