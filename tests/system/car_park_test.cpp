#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "formats/base/files/atomic_file.h"
#include "formats/reader/reader.h"
#include "tests/support/value_of.h"
#include "tests/system/program.h"

// A car park of three storeys that look alike, 2.75 m apart, without poses: each storey is a place
// of its own.

namespace sightline {
namespace {

namespace fs = std::filesystem;
constexpr double kStorey_m = 2.75;

struct Found {
  std::vector<Eigen::Vector3d> world_m;  // of each scan
  std::string text;                      // the whole table
};

Found trajectory_of(const fs::path& config) {
  Found found;
  found.text = run_successfully("dump " + config.string() + " --what trajectory --format csv").out;
  std::istringstream lines(found.text);
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
  std::vector<std::size_t> columns(3, 0);
  bool has_names = false;
  for (std::string line; std::getline(lines, line);) {
    for (int axis = 0; axis < 3; ++axis) {
      const std::string name = std::string("# origin_world_") + "xyz"[axis] + "_m: ";
      if (line.starts_with(name)) origin_m[axis] = std::stod(line.substr(name.size()));
    }
    if (line.starts_with("#") || line.empty()) continue;
    std::vector<std::string> cells;
    std::istringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
    if (!has_names) {
      for (std::size_t i = 0; i < cells.size(); ++i) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          if (cells[i] == std::string(1, "xyz"[axis]) + "_m") columns[axis] = i;
        }
      }
      has_names = true;
      continue;
    }
    found.world_m.push_back(origin_m + Eigen::Vector3d(std::stod(cells[columns[0]]),
                                                       std::stod(cells[columns[1]]),
                                                       std::stod(cells[columns[2]])));
  }
  return found;
}

// Where the sensor was, 1.8 m above the vehicle's origin.
std::vector<Eigen::Vector3d> true_sensors_m(const fs::path& tum) {
  std::vector<Eigen::Vector3d> places_m;
  std::istringstream lines(bytes_of(tum));
  double t = 0.0;
  Eigen::Vector3d p_m;
  Eigen::Quaterniond q;
  while (lines >> t >> p_m.x() >> p_m.y() >> p_m.z() >> q.x() >> q.y() >> q.z() >> q.w()) {
    places_m.push_back(p_m + q * Eigen::Vector3d(0.0, 0.0, 1.8));
  }
  return places_m;
}

double largest_error_m(const std::vector<Eigen::Vector3d>& found_m,
                       const std::vector<Eigen::Vector3d>& true_m) {
  const auto count = static_cast<Eigen::Index>(found_m.size());
  Eigen::Matrix3Xd found(3, count);
  Eigen::Matrix3Xd truth(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    found.col(i) = found_m[static_cast<std::size_t>(i)];
    truth.col(i) = true_m[static_cast<std::size_t>(i)];
  }
  const Eigen::Matrix4d fit = Eigen::umeyama(found, truth, false);
  const Eigen::Matrix3Xd off_m =
      ((fit.topLeftCorner<3, 3>() * found).colwise() + fit.topRightCorner<3, 1>()) - truth;
  return off_m.colwise().norm().maxCoeff();
}

TEST(CarPark, HasSitesOnEveryStoreyFromWhichTheReaderAnswers) {
  const fs::path folder = fresh_folder();
  const ProgramResult made =
      run_command(std::string(SIGHTLINE_TOWN) + " --world car-park --seed 1 --drives 0 -o " +
                  (folder / "park").string());
  ASSERT_EQ(made.status, 0) << made.err;
  const fs::path config = folder / "park.yaml";
  ASSERT_TRUE(write_file_atomically(config,
                                    "mapping: {scans: park/mapping/scans, sensor: generic-16}\n"
                                    "measure-error: {offset_count: 1}\n"
                                    "annotation: {ranges_m: [10], looks: paper}\n",
                                    IfExists::kRefuse));
  const fs::path map = folder / "park.slmap";
  run_successfully("compile " + config.string() + " -o " + map.string());

  const Found found = trajectory_of(config);
  EXPECT_NE(found.text.find("# loop_edges: 0\n"), std::string::npos) << found.text.substr(0, 400);
  const std::vector<Eigen::Vector3d> true_m =
      true_sensors_m(folder / "park" / "mapping" / "poses_true.tum");
  ASSERT_EQ(found.world_m.size(), true_m.size());
  EXPECT_LT(largest_error_m(found.world_m, true_m), 0.05);

  const MapReader reader = value_of(MapReader::open(map.string(), "searching"));
  const std::vector<MapSite> sites = value_of(reader.sites(0));
  std::array<int, 3> scans_of_storey{};
  for (std::size_t i = 0; i < found.world_m.size(); ++i) {
    const Eigen::Vector3d& p_m = found.world_m[i];
    const RangeAnswer answer =
        value_of(reader.observation_range({p_m.x(), p_m.y(), p_m.z()}, 0.25));
    ASSERT_NE(answer.site, kNoSite) << "scan " << i;
    EXPECT_LT(answer.distance_m, 1.0) << "scan " << i;
    EXPECT_LT(std::abs(sites[answer.site].position_world_m[2] - p_m.z()), 0.5) << "scan " << i;
    const double storeys = (true_m[i].z() - true_m[0].z()) / kStorey_m;
    ++scans_of_storey.at(static_cast<std::size_t>(std::lround(storeys)));
  }
  for (const int count : scans_of_storey) EXPECT_GT(count, 60);
}

}  // namespace
}  // namespace sightline
