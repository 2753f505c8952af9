#include <gtest/gtest.h>
#include <pcl/io/ply_io.h>
#include <pcl/point_types.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>

#include "compiler/views/exports/ply.h"
#include "formats/base/files/atomic_file.h"
#include "tests/formats/map/random_map.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

float number_at(const pcl::PCLPointCloud2& cloud, std::size_t point, const std::string& name) {
  const auto field = std::ranges::find(cloud.fields, name, &pcl::PCLPointField::name);
  EXPECT_NE(field, cloud.fields.end()) << name;
  EXPECT_EQ(field->datatype, pcl::PCLPointField::FLOAT32) << name;
  float value = 0.0F;
  std::memcpy(&value, &cloud.data[point * cloud.point_step + field->offset], sizeof value);
  return value;
}

Eigen::Vector3d numbers_at(const pcl::PCLPointCloud2& cloud, std::size_t point,
                           const std::array<std::string, 3>& names) {
  return {number_at(cloud, point, names[0]), number_at(cloud, point, names[1]),
          number_at(cloud, point, names[2])};
}

// The covariance that rotation and scales give is the ND's; so are mean and colour.
TEST(NdGaussians, AreReadByPclWithMeanCovarianceAndColour) {
  NdtMap ndt = random_map({.seed = 3, .nd_count = 20'000}).ndt;  // more than one piece
  ndt.frame.origin_world_m = {64.0, -128.0, 0.0};
  const std::filesystem::path file = scratch_folder() / "nds.ply";
  const auto write = [&](const ByteSink& sink) { return write_nd_gaussians(ndt, sink); };
  ASSERT_TRUE(write_file_atomically(file, write, IfExists::kReplace));
  EXPECT_LT(std::filesystem::file_size(file), kGaussianBytes * ndt.nds.size() + 1000);
  pcl::PCLPointCloud2 cloud;
  ASSERT_EQ(pcl::io::loadPLYFile(file.string(), cloud), 0);
  ASSERT_EQ(cloud.width * cloud.height, ndt.nds.size());
  pcl::PointCloud<pcl::PointXYZRGB> coloured;
  pcl::fromPCLPointCloud2(cloud, coloured);
  for (std::size_t i = 0; i < ndt.nds.size(); ++i) {
    const Nd& nd = ndt.nds[i];
    const Eigen::Vector3d mean_m = numbers_at(cloud, i, {"x", "y", "z"});
    ASSERT_LT((mean_m - nd.mean_m - ndt.frame.origin_world_m).norm(), 1e-4);
    const Eigen::Vector3d xyz = numbers_at(cloud, i, {"rot_1", "rot_2", "rot_3"});
    const Eigen::Quaterniond rotation(number_at(cloud, i, "rot_0"), xyz.x(), xyz.y(), xyz.z());
    const Eigen::Vector3d sigmas_m =
        numbers_at(cloud, i, {"scale_0", "scale_1", "scale_2"}).array().exp();
    const Eigen::Matrix3d axes = rotation.toRotationMatrix() * sigmas_m.asDiagonal();
    const Eigen::Matrix3d expected_m2 =
        nd.eigenvectors * nd.eigenvalues_m2.asDiagonal() * nd.eigenvectors.transpose();
    ASSERT_LT((axes * axes.transpose() - expected_m2).norm(), 1e-5 * expected_m2.norm()) << i;
    const int blue = std::array{0, 178, 153}[static_cast<std::size_t>(dimension_class(nd)) - 1];
    ASSERT_EQ(coloured[i].b, blue);
    const double harmonic = number_at(cloud, i, "f_dc_2");
    ASSERT_NEAR(255.0 * (0.5 + harmonic / std::sqrt(4.0 * std::numbers::pi)), blue, 1e-3);
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
