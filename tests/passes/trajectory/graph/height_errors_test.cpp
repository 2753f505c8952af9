#include "passes/trajectory/graph/height_errors.h"

#include <gtest/gtest.h>
#include <cmath>
#include <numbers>
#include <vector>

#include "formats/base/random.h"

namespace sightline {
namespace {

Pose at(double x_m, double y_m) { return Pose(Eigen::Translation3d(x_m, y_m, 0.0)); }

std::vector<GraphEdge> steps_between(const std::vector<Pose>& poses, double sigma_m,
                                     double sigma_rad) {
  std::vector<GraphEdge> steps;
  for (std::uint32_t k = 1; k < poses.size(); ++k) {
    steps.push_back({k - 1, k, poses[k - 1].inverse() * poses[k], sigma_m, sigma_rad});
  }
  return steps;
}

TEST(HeightErrors, GrowByEachStepAndByItsTurnTimesTheWayBehindIt) {
  const std::vector<Pose> poses = {at(0.0, 0.0), at(3.0, 0.0), at(6.0, 0.0), at(6.0, 4.0)};
  const HeightErrors errors(steps_between(poses, 0.1, 0.01), poses);
  // The steps end 5 m, 4 m and 0 m from the last pose.
  EXPECT_NEAR(errors.sigma_m(0, 3), std::sqrt(3.0 * 0.01 + 1e-4 * (25.0 + 16.0)), 1e-12);
  EXPECT_NEAR(errors.sigma_m(1, 3), std::sqrt(2.0 * 0.01 + 1e-4 * 16.0), 1e-12);
  EXPECT_EQ(errors.sigma_m(2, 2), 0.0);
}

TEST(HeightErrors, LeaveOutThePieceBreakThatIsNoStep) {
  const std::vector<Pose> poses = {at(0.0, 0.0), at(1.0, 0.0), at(50.0, 0.0), at(51.0, 0.0)};
  std::vector<GraphEdge> steps = steps_between(poses, 0.1, 0.01);
  steps.erase(steps.begin() + 1);
  const HeightErrors errors(steps, poses);
  EXPECT_NEAR(errors.sigma_m(2, 3), 0.1, 1e-9);
  EXPECT_NEAR(errors.sigma_m(0, 1), 0.1, 1e-9);
}

// A drive round a block with random errors of each step: the heights that they add up to.
TEST(HeightErrors, AgreeWithDrivesWhoseStepsHaveSuchErrors) {
  constexpr int kCount = 200;
  constexpr double kSigma_m = 0.005;
  constexpr double kSigma_rad = 0.002;
  std::vector<Pose> poses = {Pose::Identity()};
  const double turn_rad = 2.0 * std::numbers::pi / kCount;
  Pose step(Eigen::Translation3d(1.0, 0.0, 0.0));
  step.linear() = Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  for (int k = 1; k < kCount; ++k) poses.push_back(poses.back() * step);
  Random random(5);
  double sum_m2 = 0.0;
  constexpr int kDrives = 400;
  for (int drive = 0; drive < kDrives; ++drive) {
    Pose end = poses.front();
    for (int k = 1; k < kCount; ++k) {
      const auto draw = [&](double sigma) {
        return Eigen::Vector3d(sigma * random.normal(), sigma * random.normal(),
                               sigma * random.normal());
      };
      end = end * step;
      end.translation() += draw(kSigma_m);
      const Eigen::Vector3d turned_rad = draw(kSigma_rad);
      const Eigen::AngleAxisd error(turned_rad.norm(), turned_rad.normalized());
      end.linear() = end.linear() * error.toRotationMatrix();
    }
    sum_m2 += end.translation().z() * end.translation().z();
  }
  const HeightErrors errors(steps_between(poses, kSigma_m, kSigma_rad), poses);
  EXPECT_NEAR(errors.sigma_m(0, kCount - 1) / std::sqrt(sum_m2 / kDrives), 1.0, 0.1);
}

}  // namespace
}  // namespace sightline
