#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "formats/base/files/atomic_file.h"
#include "formats/map/map_reader.h"
#include "tests/formats/foreign/maps/apollo_writer.h"
#include "tests/support/value_of.h"
#include "tests/system/program.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr const char* kFew =
    " --set measure-error.offset_count=2 --set annotation.ranges_m=10,30 --set "
    "annotation.looks=paper -q --no-cache";

const Eigen::Vector3d kCorner_m(588352.0, 4141184.0, -30.3);

// A street of 60 m between two walls with pillars, 25 points on a square metre.
std::vector<Eigen::Vector3d> street_points() {
  std::vector<Eigen::Vector3d> points_m;
  for (double x_m = 0.1; x_m < 60.0; x_m += 0.2) {
    for (double y_m = 0.1; y_m < 20.0; y_m += 0.2) {
      points_m.push_back(kCorner_m + Eigen::Vector3d(x_m, y_m, 0.0));
    }
    for (double z_m = 0.1; z_m < 5.0; z_m += 0.2) {
      const double pillar_m = static_cast<int>(x_m / 2.0) % 3 == 0 ? 0.6 : 0.0;
      points_m.push_back(kCorner_m + Eigen::Vector3d(x_m, 1.1 + pillar_m, z_m));
      points_m.push_back(kCorner_m + Eigen::Vector3d(x_m, 18.9 - pillar_m, z_m));
    }
  }
  return points_m;
}

class AnnotateApolloTest : public testing::Test {
 protected:
  AnnotateApolloTest() {
    constexpr std::uint32_t kNodeCells = 32;
    write("apollo/config.xml", apollo_config(1.0, kNodeCells));
    for (const auto& [place, node] : apollo_nodes(street_points(), 1.0, kNodeCells)) {
      const ApolloTestIndex index{0, 10, place.first, place.second};
      write("apollo/" + apollo_path(index), apollo_file(index, zlib_packed(apollo_body(node))));
    }
    std::string line = "x,y\n";
    for (const double x_m : {20.0, 30.0}) {
      line +=
          std::to_string(kCorner_m.x() + x_m) + "," + std::to_string(kCorner_m.y() + 10.0) + "\n";
    }
    write("line.csv", line);
  }
  void write(const std::string& name, const std::string& content) {
    fs::create_directories((folder_ / name).parent_path());
    ASSERT_TRUE(write_file_atomically(folder_ / name, content, IfExists::kReplace));
  }
  ProgramResult annotate(const std::string& options) {
    return run_sightline("annotate " + (folder_ / "apollo").string() + " --route " +
                         (folder_ / "line.csv").string() + " " + options + " -o " +
                         output_.string() + kFew);
  }
  fs::path folder_ = fresh_folder();
  fs::path output_ = folder_ / "street.slmap";
};

TEST_F(AnnotateApolloTest, TakesItsNdsInItsZoneAndSaysWhatItLacks) {
  const ProgramResult run = annotate("--sensor generic-16");
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("contains no surface"));
  EXPECT_THAT(run.err, HasSubstr("no scan was recorded at"));
  const CompiledMap map = value_of(read_map(output_));
  EXPECT_EQ(map.world, "utm:10N");
  EXPECT_EQ(map.ndt.cell_m, 1.0);
  EXPECT_EQ(map.measurement.mapping_drive, "apollo");
  ASSERT_EQ(map.sites.sites.size(), 11U);
  const Site& first = map.sites.sites.front();
  EXPECT_LT((map.sites.frame.origin_world_m + first.T_map_vehicle.translation() - kCorner_m -
             Eigen::Vector3d(20.0, 10.0, 0.0))
                .head<2>()
                .norm(),
            1e-5);
  const double height_m = map.sites.frame.origin_world_m.z() + first.p_map_m.z() - kCorner_m.z();
  EXPECT_GT(height_m, 1.0);
  EXPECT_LT(height_m, 3.0) << "the sensor stands on the ground of the NDs";
  run_successfully("verify " + output_.string());
}

TEST_F(AnnotateApolloTest, IsTheSameFromAConfigurationWhichNamesEveryNode) {
  ASSERT_EQ(annotate("--sensor generic-16").status, 0);
  write("street.yaml", "map: {points: apollo, sensor: generic-16}\nroute: {file: line.csv}\n");
  const std::string config = (folder_ / "street.yaml").string();
  const std::string again = (folder_ / "again.slmap").string();
  run_successfully("compile " + config + " --threads 1 --depfile " + again + ".d -o " + again +
                   kFew);
  EXPECT_TRUE(*read_file(output_) == *read_file(again));
  const std::string depends = *read_text_file(again + ".d");
  EXPECT_THAT(depends, HasSubstr("config.xml"));
  EXPECT_THAT(depends, HasSubstr("map/000/north/10/"));
  const ProgramResult exported =
      run_sightline("export " + config + " --format autoware -o " + (folder_ / "points").string());
  EXPECT_EQ(exported.status, 64) << exported.err;
  EXPECT_THAT(exported.err, HasSubstr("NDs and no points"));
}

TEST_F(AnnotateApolloTest, RefusesAnotherWorldAndDamage) {
  const auto expect_refused = [&](const std::string& options, int status,
                                  const std::string& mention) {
    const ProgramResult run = annotate(options);
    EXPECT_EQ(run.status, status) << run.err;
    EXPECT_THAT(run.err, HasSubstr(mention));
    EXPECT_FALSE(fs::exists(output_));
  };
  expect_refused("", 64, "--sensor is required");
  expect_refused("--sensor generic-16 --world utm:32N", 64,
                 "the coordinate system of the compiled map is utm:10N");
  fs::path node;
  for (const fs::directory_entry& entry :
       fs::recursive_directory_iterator(folder_ / "apollo/map")) {
    if (entry.is_regular_file()) node = entry.path();
  }
  fs::resize_file(node, fs::file_size(node) / 2);
  expect_refused("--sensor generic-16", 65, "SL2006 truncated-scan");
}

}  // namespace
}  // namespace sightline
