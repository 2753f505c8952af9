#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>
#include <sstream>

#include "formats/base/files/atomic_file.h"
#include "tests/support/real_data.h"
#include "tests/system/program.h"

// A vehicle that hides the rear 70 degrees from its own sensor: what a site sees comes from the
// map, and the map has seen behind the vehicle from where it stood before.

namespace sightline {
namespace {

namespace fs = std::filesystem;

std::map<std::string, std::vector<double>> columns_of(const std::string& csv) {
  std::istringstream lines(csv);
  std::vector<std::string> names;
  std::map<std::string, std::vector<double>> columns;
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream cells(line);
    std::size_t index = 0;
    const bool is_header = names.empty();
    for (std::string cell; std::getline(cells, cell, ','); ++index) {
      if (is_header) {
        names.push_back(cell);
      } else {
        columns[names.at(index)].push_back(std::strtod(cell.c_str(), nullptr));
      }
    }
  }
  return columns;
}

// Share of rays within 35 degrees of an azimuth that hit something within 20 m.
double occupancy(const std::map<std::string, std::vector<double>>& depth, double azimuth_deg) {
  double rays = 0.0;
  double hits = 0.0;
  for (std::size_t i = 0; i < depth.at("distance_m").size(); ++i) {
    if (std::abs(std::remainder(depth.at("azimuth_deg")[i] - azimuth_deg, 360.0)) > 35.0) continue;
    rays += 1.0;
    hits += depth.at("distance_m")[i] <= 20.0 ? 1.0 : 0.0;
  }
  return hits / rays;
}

TEST(RearSector, IsSeenByTheMapWhereTheVehicleHasPassed) {
  const RealData data = real_data("mulran_kaist03");
  if (!data.missing.empty()) GTEST_SKIP() << data.missing;
  const fs::path recording = data.folder / "mulran_kaist03";
  const fs::path yaml = fresh_folder() / "drive.yaml";
  ASSERT_TRUE(write_file_atomically(yaml,
                                    "mapping: {scans: " + (recording / "Scans").string() +
                                        ", poses: " + (recording / "optimized_poses.txt").string() +
                                        ", sensor: os1-64, poses_of: sensor}\n",
                                    IfExists::kReplace));
  const std::string dump = "dump " + yaml.string() + " -q --format csv --what ";
  const auto sites = columns_of(run_sightline(dump + "sites").out);
  const std::size_t count = sites.at("p_x_m").size();
  ASSERT_GT(count, 20U);
  for (std::size_t site = count - 3; site < count; ++site) {
    const auto depth = columns_of(run_sightline(dump + "depth --site " + std::to_string(site)).out);
    const double ahead_deg = std::atan2(sites.at("p_y_m")[site] - sites.at("p_y_m")[site - 1],
                                        sites.at("p_x_m")[site] - sites.at("p_x_m")[site - 1]) *
                             180.0 / std::numbers::pi;
    const double front = occupancy(depth, ahead_deg);
    const double rear = occupancy(depth, ahead_deg + 180.0);
    EXPECT_GT(front, 0.4) << "site " << site;
    // Measured: 0.41 to 0.42 behind, 0.51 to 0.52 ahead. From one scan alone it is 0 behind.
    EXPECT_GT(rear, 0.7 * front) << "site " << site;
  }
}

}  // namespace
}  // namespace sightline
