#include <gtest/gtest.h>
#include <pcl/io/ply_io.h>
#include <pcl/point_types.h>

#include <cstring>

#include "compiler/views/exports/ply.h"
#include "formats/base/files/atomic_file.h"
#include "tests/formats/map/random_map.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

// Every vertex of an ellipsoid is two standard deviations from the mean: its Mahalanobis distance
// by the raw covariance is 2.
TEST(NdMesh, IsReadByPclAndLiesAtTwoStandardDeviations) {
  NdtMap ndt = random_map({.seed = 3, .nd_count = 1500}).ndt;  // more than one piece
  ndt.frame.origin_world_m = {64.0, -128.0, 0.0};
  const std::filesystem::path file = scratch_folder() / "nds.ply";
  const auto write = [&](const ByteSink& sink) { return write_nd_ellipsoids(ndt, sink); };
  ASSERT_TRUE(write_file_atomically(file, write, IfExists::kReplace));
  pcl::PolygonMesh mesh;
  ASSERT_EQ(pcl::io::loadPLYFile(file.string(), mesh), 0);
  pcl::PointCloud<pcl::PointXYZRGB> vertices;
  pcl::fromPCLPointCloud2(mesh.cloud, vertices);
  ASSERT_EQ(vertices.size(), ndt.nds.size() * kEllipsoidVertices);
  ASSERT_EQ(mesh.polygons.size(), ndt.nds.size() * kEllipsoidFaces);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Nd& nd = ndt.nds[i / kEllipsoidVertices];
    const Eigen::Vector3d d_m =
        vertices[i].getVector3fMap().cast<double>() - nd.mean_m - ndt.frame.origin_world_m;
    EXPECT_NEAR(std::sqrt(d_m.dot(nd.covariance_m2.inverse() * d_m)), 2.0, 0.05);
    const int blue = std::array{0, 178, 153}[static_cast<std::size_t>(dimension_class(nd)) - 1];
    EXPECT_EQ(vertices[i].b, blue);
  }
  for (std::size_t i = 0; i < mesh.polygons.size(); ++i) {
    const auto& corners = mesh.polygons[i].vertices;
    ASSERT_EQ(corners.size(), 3u);
    for (const auto corner : corners) {
      EXPECT_EQ(static_cast<std::size_t>(corner) / kEllipsoidVertices, i / kEllipsoidFaces);
    }
  }
}

TEST(PointsPly, IsReadByPclWithEveryPoint) {
  SurfacePoints surface;
  surface.points_m = {{0.1, 0.1, 0.1}, {0.3, 0.1, 0.1}, {-0.1, 5.0, 1.0}};
  const std::vector<Eigen::Vector3d> thinned = value_of(thinned_points(surface, 0.5));
  ASSERT_EQ(thinned.size(), 2u);
  EXPECT_EQ(thinned[0], Eigen::Vector3d(-0.1, 5.0, 1.0));
  EXPECT_LT((thinned[1] - Eigen::Vector3d(0.2, 0.1, 0.1)).norm(), 1e-12);
  EXPECT_EQ(thinned_points(surface, 0.0)->size(), 3u);
  EXPECT_EQ(thinned_points(surface, -1.0).error().code, ErrorCode::kBadValue);
  const std::filesystem::path file = scratch_folder() / "points.ply";
  ASSERT_TRUE(write_file_atomically(file, points_ply(thinned), IfExists::kReplace));
  pcl::PCLPointCloud2 cloud;  // PCL's own points are of floats, these of doubles
  ASSERT_EQ(pcl::io::loadPLYFile(file.string(), cloud), 0);
  ASSERT_EQ(cloud.width * cloud.height, 2u);
  const auto coordinate = [&](std::size_t point, std::size_t axis) {
    EXPECT_EQ(cloud.fields[axis].datatype, pcl::PCLPointField::FLOAT64);
    double value = 0.0;
    std::memcpy(&value, &cloud.data[point * cloud.point_step + cloud.fields[axis].offset],
                sizeof value);
    return value;
  };
  EXPECT_EQ(coordinate(0, 1), 5.0);
  EXPECT_NEAR(coordinate(1, 0), 0.2, 1e-12);
}

}  // namespace
}  // namespace sightline
