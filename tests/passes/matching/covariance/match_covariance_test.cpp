#include "passes/matching/covariance/match_covariance.h"

#include <gtest/gtest.h>
#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "tests/passes/matching/covariance/random_positive.h"

namespace sightline {
namespace {

// Constrains nothing along x.
StructureEvidence tunnel_like() {
  StructureEvidence evidence;
  evidence.information.diagonal() << 0.0, 1e5, 1e5, 1e7, 1e7, 1e6;
  return evidence;
}

TEST(MatchInformation, IsTheInverseOfTheSumOfCovariances) {
  Random random(1);
  for (int trial = 0; trial < 50; ++trial) {
    StructureEvidence evidence;
    evidence.information = random_positive(random, 1.0);
    const InformationScale scale{random.uniform(0.5, 4.0), random.uniform(0.01, 0.5),
                                 random.uniform(0.01, 0.5)};
    Matrix6d covariance = scale.variance_factor * evidence.information.inverse();
    for (int i = 0; i < 6; ++i) {
      covariance(i, i) += i < 3 ? scale.map_m * scale.map_m : scale.map_rad * scale.map_rad;
    }
    const Matrix6d found = match_information(evidence, scale);
    EXPECT_LT((found * covariance - Matrix6d::Identity()).norm(), 1e-8);
  }
}

TEST(MatchInformation, StaysNothingWhereStructuresConstrainNothing) {
  const Matrix6d found = match_information(tunnel_like(), default_information_scale());
  EXPECT_EQ(found.row(0).norm(), 0.0);
  EXPECT_GT(found(1, 1), 1.0 / (0.02 * 0.02));
}

TEST(MatchInformation, IsLittleAlongTheStepThatStructuresAskFor) {
  StructureEvidence evidence = tunnel_like();
  evidence.information(0, 0) = 1e4;
  constexpr double kOff_m = 0.3;
  evidence.descent[1] = kOff_m * evidence.information(1, 1);
  const Matrix6d covariance = match_information(evidence, {}).inverse();
  EXPECT_NEAR(std::sqrt(covariance(1, 1)), kOff_m, 0.01);
  EXPECT_NEAR(std::sqrt(covariance(0, 0)), 0.01, 1e-6);
}

TEST(MatchCovariance, OfAnUnknownStartIsTheInverseOfTheInformationWhereItHasOne) {
  Random random(2);
  for (int trial = 0; trial < 20; ++trial) {
    const Matrix6d information = random_positive(random, 100.0);
    const Matrix6d found = covariance_of_unknown_start(information);
    EXPECT_LT((found * information - Matrix6d::Identity()).norm(), 0.2);
    EXPECT_TRUE(is_covariance(found));
  }
  EXPECT_NEAR(covariance_of_unknown_start(tunnel_like().information)(0, 0), 1e4, 1e-6);
}

TEST(WeakAxes, AreThoseOfTheVehicle) {
  const Matrix6d along_x = match_information(tunnel_like(), default_information_scale());
  const auto weak = [](const Matrix6d& information, const Pose& T_map_vehicle) {
    return weak_axes(covariance_of_unknown_start(information), T_map_vehicle);
  };
  EXPECT_EQ(weak(along_x, Pose::Identity()), 1u);
  Pose turned = Pose::Identity();
  turned.linear() << 0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
  EXPECT_EQ(weak(along_x, turned), 2u);
  EXPECT_EQ(weak(Matrix6d::Zero(), turned), 63u);
  EXPECT_EQ(weak(1e5 * Matrix6d::Identity(), turned), 0u);
}

TEST(IsCovariance, RefusesWhatIsNone) {
  Matrix6d matrix = Matrix6d::Identity();
  EXPECT_TRUE(is_covariance(matrix));
  EXPECT_TRUE(is_covariance(Matrix6d::Zero()));
  matrix(2, 4) = 0.5;
  EXPECT_FALSE(is_covariance(matrix));
  matrix = Matrix6d::Identity();
  matrix(3, 3) = -1.0;
  EXPECT_FALSE(is_covariance(matrix));
  matrix(3, 3) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(is_covariance(matrix));
}

}  // namespace
}  // namespace sightline
