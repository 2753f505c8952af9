#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>
#include <pcl/point_types.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include "formats/base/files/atomic_file.h"
#include "formats/foreign/text/pose_file.h"
#include "formats/reader/reader.h"
#include "tests/support/value_of.h"
#include "tests/system/program.h"

// What `sightline export` writes of a compiled town, as GDAL, PCL and yaml-cpp read it, beside what
// `sightline dump` prints of the same map.

namespace sightline {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

// Rows of a CSV whose cells hold no quotes within quotes, by the names of its columns; `# name:
// value` are facts.
struct Csv {
  std::map<std::string, double> facts;
  std::vector<std::map<std::string, std::string>> rows;

  [[nodiscard]] double number(std::size_t row, const std::string& column) const {
    return std::stod(rows[row].at(column));
  }
};

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells(1);
  bool is_quoted = false;
  for (const char c : line) {
    if (c == '"') {
      is_quoted = !is_quoted;
    } else if (c == ',' && !is_quoted) {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  return cells;
}

Csv csv_of(const std::string& text) {
  Csv csv;
  std::vector<std::string> columns;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("# ")) {
      csv.facts[line.substr(2, colon - 2)] = std::strtod(line.c_str() + colon + 2, nullptr);
    } else if (columns.empty()) {
      columns = cells_of(line);
    } else {
      const std::vector<std::string> cells = cells_of(line);
      std::map<std::string, std::string>& row = csv.rows.emplace_back();
      for (std::size_t i = 0; i < std::min(cells.size(), columns.size()); ++i) {
        row[columns[i]] = cells[i];
      }
    }
  }
  return csv;
}

std::string dumped(const std::string& source, const std::string& what) {
  return run_successfully("dump " + source + " -q --format csv --what " + what).out;
}

TEST(Exports, GdalReadsEverySiteOfTheGeoJsonWhereTheDumpPutsIt) {
  if (run_command("command -v ogrinfo ogr2ogr").status != 0) {
    GTEST_SKIP() << "there is no ogrinfo (Debian package gdal-bin)";
  }
  const fs::path file = fresh_folder() / "route.geojson";
  export_to(file, map_file(), "--format geojson --world utm:32N");
  const Csv sites = csv_of(dumped(map_file(), "sites"));
  ASSERT_GT(sites.rows.size(), 80U);

  const ProgramResult summary = run_command("ogrinfo -ro -al -so '" + file.string() + "'");
  EXPECT_EQ(summary.status, 0) << summary.err;
  EXPECT_THAT(summary.out,
              HasSubstr("Feature Count: " + std::to_string(sites.rows.size() + 1) + "\n"));
  EXPECT_THAT(summary.out, HasSubstr("range_m_within_10_cm: Real"));
  EXPECT_EQ(summary.err, "") << "nothing to complain of";

  const ProgramResult back = run_command(
      "ogr2ogr -f CSV /vsistdout/ -t_srs EPSG:32632 -lco GEOMETRY=AS_XYZ -where \"site IS NOT "
      "NULL\" '" +
      file.string() + "'");
  ASSERT_EQ(back.status, 0) << back.err;
  const Csv read = csv_of(back.out);
  const Csv ranges = csv_of(dumped(map_file(), "ranges"));
  ASSERT_EQ(read.rows.size(), sites.rows.size());
  for (std::size_t i = 0; i < read.rows.size(); ++i) {
    for (const std::string axis : {"x", "y"}) {
      const std::string column = axis == "x" ? "X" : "Y";
      EXPECT_NEAR(
          read.number(i, column),
          sites.number(i, "p_" + axis + "_m") + sites.facts.at("origin_world_" + axis + "_m"),
          0.001);
    }
    EXPECT_EQ(read.number(i, "site"), sites.number(i, "site"));
    EXPECT_EQ(read.number(i, "range_m_within_10_cm"), ranges.number(2 * i, "range_m"));
    EXPECT_EQ(read.number(i, "range_m_within_25_cm"), ranges.number(2 * i + 1, "range_m"));
  }
}

TEST(Exports, GdalReadsTheGeoPackageInItsZone) {
  if (run_command("command -v ogrinfo ogr2ogr").status != 0) {
    GTEST_SKIP() << "there is no ogrinfo (Debian package gdal-bin)";
  }
  const fs::path file = fresh_folder() / "route.gpkg";
  export_to(file, map_file(), "--format gpkg --world utm:32N");
  const ProgramResult summary = run_command("ogrinfo -ro -al -so '" + file.string() + "'");
  EXPECT_EQ(summary.status, 0) << summary.err;
  EXPECT_EQ(summary.err, "") << "nothing to complain of";
  EXPECT_THAT(summary.out, HasSubstr("ID[\"EPSG\",32632]"));
  const Csv sites = csv_of(dumped(map_file(), "sites"));
  EXPECT_THAT(summary.out, HasSubstr("Feature Count: " + std::to_string(sites.rows.size()) + "\n"));
  const ProgramResult back =
      run_command("ogr2ogr -f CSV /vsistdout/ -lco GEOMETRY=AS_XYZ '" + file.string() + "' sites");
  ASSERT_EQ(back.status, 0) << back.err;
  const Csv read = csv_of(back.out);
  ASSERT_EQ(read.rows.size(), sites.rows.size());
  for (std::size_t i = 0; i < read.rows.size(); ++i) {
    EXPECT_NEAR(read.number(i, "X"), sites.number(i, "p_x_m") + sites.facts.at("origin_world_x_m"),
                1e-6);
    EXPECT_NEAR(read.number(i, "Y"), sites.number(i, "p_y_m") + sites.facts.at("origin_world_y_m"),
                1e-6);
  }
}

TEST(Exports, AnIndependentReaderChecksEachMessageForFoxglove) {
  const fs::path file = fresh_folder() / "town.mcap";
  export_to(file, map_file(), "--world enu:48.98,8.39,116.4");
  const ProgramResult read = run_command(
      std::string(SIGHTLINE_ROOT) + "/tests/system/read_foxglove_mcap.py '" + file.string() + "'");
  EXPECT_EQ(read.status, 0) << read.err;
  const std::string count = std::to_string(csv_of(dumped(map_file(), "sites")).rows.size()) + "\n";
  EXPECT_EQ(read.out, "/drive foxglove.PosesInFrame 1\n/fix foxglove.LocationFix " + count +
                          "/map/nds foxglove.PointCloud 1\n/map/route foxglove.SceneUpdate 1\n" +
                          "/map/sites foxglove.SceneUpdate 1\n/pose foxglove.PoseInFrame " + count +
                          "/site sightline.Site " + count + "/tf foxglove.FrameTransform " + count);
}

TEST(Exports, EveryCsvTableIsThatOfTheDumpInTheWorld) {
  const fs::path folder = fresh_folder() / "tables";
  export_to(folder, map_file(), "--format csv");
  const Csv known = csv_of(dumped(map_file(), "sites"));
  std::size_t tables = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    ++tables;
    const Csv read = csv_of(*read_text_file(entry.path()));
    EXPECT_TRUE(read.facts.empty()) << entry << ": facts lie in facts.csv";
    if (entry.path().stem() == "facts") continue;
    const Csv dump = csv_of(dumped(map_file(), entry.path().stem()));
    ASSERT_EQ(read.rows.size(), dump.rows.size()) << entry;
    for (std::size_t i = 0; i < read.rows.size(); ++i) {
      ASSERT_EQ(read.rows[i].size(), dump.rows[i].size());
      for (const auto& [name, cell] : dump.rows[i]) {
        const std::string axis = name.ends_with("x_m")   ? "x"
                                 : name.ends_with("y_m") ? "y"
                                 : name.ends_with("z_m") ? "z"
                                                         : "";
        if (axis.empty()) {
          ASSERT_EQ(read.rows[i].at(name), cell) << entry << " " << name;
        } else {
          ASSERT_EQ(read.number(i, name),
                    std::stod(cell) + known.facts.at("origin_world_" + axis + "_m"));
        }
      }
    }
  }
  EXPECT_EQ(tables,
            10U);  // facts, nds, sites, columns; factors, predicted and ranges, each of looks too
}

// The mean of an ND as exported clouds hold it: of the world, less whole 100 km.
Eigen::Vector3d exported(const Csv& nds, std::size_t i) {
  return {nds.number(i, "mean_x_m") + nds.facts.at("origin_world_x_m") - 400'000.0,
          nds.number(i, "mean_y_m") + nds.facts.at("origin_world_y_m") - 5'400'000.0,
          nds.number(i, "mean_z_m") + nds.facts.at("origin_world_z_m")};
}

TEST(Exports, PclReadsTheMeansOfTheNds) {
  const fs::path file = fresh_folder() / "means.pcd";
  export_to(file, map_file(), "--format pcd");
  const Csv nds = csv_of(dumped(map_file(), "nds"));
  pcl::PointCloud<pcl::PointXYZI> cloud;
  ASSERT_EQ(pcl::io::loadPCDFile(file.string(), cloud), 0);
  ASSERT_EQ(cloud.size(), nds.rows.size());
  ASSERT_GT(cloud.size(), 1000U);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d p_m = exported(nds, i);
    EXPECT_EQ(cloud[i].x, static_cast<float>(p_m.x()));
    EXPECT_EQ(cloud[i].y, static_cast<float>(p_m.y()));
    EXPECT_EQ(cloud[i].z, static_cast<float>(p_m.z()));
    EXPECT_EQ(cloud[i].intensity, static_cast<float>(nds.number(i, "point_count")));
  }
}

TEST(Exports, PclReadsAGaussianOfEveryNd) {
  const fs::path file = fresh_folder() / "nds.ply";
  export_to(file, map_file(), "--format ply");
  const Csv nds = csv_of(dumped(map_file(), "nds"));
  pcl::PointCloud<pcl::PointXYZRGB> cloud;
  ASSERT_EQ(pcl::io::loadPLYFile(file.string(), cloud), 0);
  ASSERT_EQ(cloud.size(), nds.rows.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    EXPECT_LT((cloud[i].getVector3fMap().cast<double>() - exported(nds, i)).norm(), 0.005)
        << "floats at 56 km";
  }
  EXPECT_LE(static_cast<double>(fs::file_size(file)), 60.0 * static_cast<double>(cloud.size()));
}

TEST(Exports, PclReadsEveryStandingPointOfTheConfiguration) {
  const fs::path file = fresh_folder() / "points.ply";
  export_to(file, config_file(), "--format ply --leaf 0");
  pcl::PCLPointCloud2 cloud;
  ASSERT_EQ(pcl::io::loadPLYFile(file.string(), cloud), 0);
  const Csv points = csv_of(dumped(config_file(), "points"));
  EXPECT_EQ(static_cast<double>(cloud.width) * cloud.height, points.facts.at("standing_count"));
}

std::vector<std::array<float, 3>> sorted_points(const pcl::PointCloud<pcl::PointXYZI>& cloud) {
  std::vector<std::array<float, 3>> points;
  for (const pcl::PointXYZI& p : cloud) points.push_back({p.x, p.y, p.z});
  std::ranges::sort(points);
  return points;
}

TEST(Exports, AutowaresSquaresHoldThePointsOfThePcd) {
  const fs::path folder = fresh_folder();
  export_to(folder / "map", config_file(), "--format autoware --world utm:32N");
  export_to(folder / "points.pcd", config_file(), "--format pcd");
  pcl::PointCloud<pcl::PointXYZI> all;
  ASSERT_EQ(pcl::io::loadPCDFile((folder / "points.pcd").string(), all), 0);

  const YAML::Node projector = YAML::LoadFile(folder / "map" / "map_projector_info.yaml");
  EXPECT_EQ(projector["mgrs_grid"].as<std::string>(), "32UMV");
  const YAML::Node metadata = YAML::LoadFile(folder / "map" / "pointcloud_map_metadata.yaml");
  pcl::PointCloud<pcl::PointXYZI> joined;
  for (const auto& entry : metadata) {
    const auto name = entry.first.as<std::string>();
    if (!name.ends_with(".pcd")) continue;
    pcl::PointCloud<pcl::PointXYZI> square;
    ASSERT_EQ(pcl::io::loadPCDFile((folder / "map" / "pointcloud_map.pcd" / name).string(), square),
              0);
    joined += square;
  }
  EXPECT_GT(all.size(), 10'000U);
  EXPECT_EQ(sorted_points(joined), sorted_points(all));
}

// A vehicle that localizes in the exported map asks the compiled one where it finds itself: its
// scans lie on the exported points, and every answer is that of its place in the world.
TEST(Exports, AVehicleInTheExportedMapGetsTheAnswersOfItsPlace) {
  const fs::path folder = fresh_folder();
  export_to(folder / "points.pcd", config_file(), "--format pcd");
  pcl::PointCloud<pcl::PointXYZI> exported_map;
  ASSERT_EQ(pcl::io::loadPCDFile((folder / "points.pcd").string(), exported_map), 0);
  const auto voxel = [](const Eigen::Vector3d& p_m) {
    return std::array{std::floor(p_m.x()), std::floor(p_m.y()), std::floor(p_m.z())};
  };
  std::set<std::array<double, 3>> occupied;
  for (const pcl::PointXYZI& p : exported_map) {
    occupied.insert(voxel(p.getVector3fMap().cast<double>()));
  }
  const MapReader reader = value_of(MapReader::open(map_file(), "searching"));
  const Eigen::Vector3d taken_m(reader.info().export_origin_world_m.data());
  const fs::path drive = compiled_town() / "drive_1";
  const std::vector<PoseRow> poses = value_of(read_poses(drive / "poses.tum", PoseFormat::kTum));
  std::size_t asked = 0;
  for (const PoseRow& row : poses) {
    const Eigen::Vector3d world_m = row.T_world_vehicle.translation();
    const Eigen::Vector3d in_export_m = world_m - taken_m;
    const auto answer = [&](const Eigen::Vector3d& p_m) {
      return *reader.observation_range({p_m.x(), p_m.y(), p_m.z()}, 0.10);
    };
    const RangeAnswer of_export = answer(in_export_m + taken_m);
    EXPECT_EQ(of_export.site, answer(world_m).site);
    EXPECT_EQ(of_export.range_m, answer(world_m).range_m);
    EXPECT_EQ(of_export.flags & kAnswerFar, 0U);
    ++asked;
  }
  EXPECT_GT(asked, 40U);
  pcl::PointCloud<pcl::PointXYZI> scan;
  ASSERT_EQ(pcl::io::loadPCDFile((drive / "scans" / "000000.pcd").string(), scan), 0);
  Pose T_export_vehicle = poses.front().T_world_vehicle;
  T_export_vehicle.translation() -= taken_m;
  std::size_t on_map = 0;
  for (const pcl::PointXYZI& p : scan) {
    on_map += occupied.count(voxel(T_export_vehicle * p.getVector3fMap().cast<double>()));
  }
  EXPECT_GT(static_cast<double>(on_map), 0.7 * static_cast<double>(scan.size()));
}

}  // namespace
}  // namespace sightline
