#include "passes/trajectory/graph/planes.h"

#include <gtest/gtest.h>

#include "formats/base/random.h"

namespace sightline {
namespace {

using Points = std::vector<Eigen::Vector3f>;

// Scans from places a metre apart, of ground and a wall, with noise.
class PlanesOfAStreet : public ::testing::Test {
 protected:
  static constexpr std::uint32_t kCount = 5;

  void SetUp() override {
    Random random(3);
    for (std::uint32_t k = 0; k < kCount; ++k) {
      Pose T_map_lidar = Pose::Identity();
      T_map_lidar.translation() = Eigen::Vector3d(k, 0.1 * k, 2.0);
      Points& points = points_.emplace_back();
      for (int i = 0; i < 4000; ++i) {
        const double x_m = random.uniform(0.0, 12.0);
        const double along_m = random.uniform(0.0, 6.0);
        const double off_m = random.uniform(-0.02, 0.02);
        const Eigen::Vector3d at_m = i % 2 == 0 ? Eigen::Vector3d(x_m, along_m, off_m)
                                                : Eigen::Vector3d(x_m, 6.5 + off_m, along_m);
        points.push_back((T_map_lidar.inverse() * at_m).cast<float>());
      }
      poses_.push_back(T_map_lidar);
    }
  }

  [[nodiscard]] PlaneEquations equations(const std::vector<bool>& is_held) const {
    std::vector<PlaneScan> scans;
    for (std::uint32_t k = 0; k < kCount; ++k)
      scans.push_back({k, poses_[k], &points_[k], is_held[k]});
    return plane_equations(scans, {0.0, 0.0}, {16.0, 16.0});
  }

 private:
  std::vector<Points> points_;
  std::vector<Pose> poses_;
};

TEST_F(PlanesOfAStreet, HeldScansContributeToPlanesAndHaveNoRows) {
  const PlaneEquations all = equations(std::vector<bool>(kCount, false));
  const std::vector<bool> is_held = {true, false, true, false, true};
  const PlaneEquations some = equations(is_held);
  EXPECT_GT(all.hessian.cwiseAbs().maxCoeff(), 1.0);
  for (Eigen::Index i = 0; i < kCount; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) {
      const auto block = some.hessian.block<6, 6>(6 * i, 6 * j);
      const bool is_sought =
          !is_held[static_cast<std::size_t>(i)] && !is_held[static_cast<std::size_t>(j)];
      if (is_sought) {
        EXPECT_EQ(block, (all.hessian.block<6, 6>(6 * i, 6 * j))) << i << " " << j;
      } else {
        EXPECT_TRUE(block.isZero(0.0)) << i << " " << j;
      }
    }
    const auto gradient = some.gradient.segment<6>(6 * i);
    if (is_held[static_cast<std::size_t>(i)]) {
      EXPECT_TRUE(gradient.isZero(0.0)) << i;
    } else {
      EXPECT_EQ(gradient, all.gradient.segment<6>(6 * i)) << i;
    }
  }
}

TEST_F(PlanesOfAStreet, HeldScansAloneGiveNoEquations) {
  const PlaneEquations none = equations(std::vector<bool>(kCount, true));
  EXPECT_TRUE(none.hessian.isZero(0.0));
  EXPECT_TRUE(none.gradient.isZero(0.0));
}

}  // namespace
}  // namespace sightline
