#include "passes/trajectory/sweep/turn_curve.h"

#include <gtest/gtest.h>

#include "tests/passes/trajectory/sweep/uneven_turns.h"

namespace sightline {
namespace {

constexpr std::int64_t kTenth_ns = 100'000'000;

TurnEnds ends_of(const VehicleMotion& motion, std::int64_t from_ns, std::int64_t to_ns) {
  return {from_ns, to_ns, motion(1e-9 * static_cast<double>(from_ns)).linear(),
          motion(1e-9 * static_cast<double>(to_ns)).linear()};
}

double angle_between_rad(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return Eigen::AngleAxisd(a.transpose() * b).angle();
}

// The definition by other means: quaternions, steps of 5 microseconds, slerp.
Eigen::Quaterniond integrated(const std::vector<TurnRate>& rates, std::int64_t from_ns,
                              std::int64_t to_ns) {
  constexpr std::int64_t kStep_ns = 5'000;
  Eigen::Quaterniond turned = Eigen::Quaterniond::Identity();
  std::size_t i = 0;
  for (std::int64_t at_ns = from_ns; at_ns < to_ns; at_ns += kStep_ns) {
    const std::int64_t step_ns = std::min(kStep_ns, to_ns - at_ns);
    const std::int64_t middle_ns = at_ns + step_ns / 2;
    while (rates[i + 1].stamp_ns < middle_ns) ++i;
    const double share = static_cast<double>(middle_ns - rates[i].stamp_ns) /
                         static_cast<double>(rates[i + 1].stamp_ns - rates[i].stamp_ns);
    const Eigen::Vector3d rate =
        (1.0 - share) * rates[i].rate_rad_per_s + share * rates[i + 1].rate_rad_per_s;
    const double angle_rad = rate.norm() * 1e-9 * static_cast<double>(step_ns);
    turned = turned * Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, rate.normalized()));
  }
  return turned.normalized();
}

Eigen::Matrix3d by_quaternions(const std::vector<TurnRate>& rates, const TurnEnds& ends,
                               std::int64_t time_ns) {
  const Eigen::Quaterniond whole(ends.R_map_from.transpose() * ends.R_map_to);
  const Eigen::Quaterniond left_over =
      integrated(rates, ends.from_ns, ends.to_ns).conjugate() * whole;
  const double s =
      static_cast<double>(time_ns - ends.from_ns) / static_cast<double>(ends.to_ns - ends.from_ns);
  const Eigen::Quaterniond turned =
      integrated(rates, ends.from_ns, time_ns) * Eigen::Quaterniond::Identity().slerp(s, left_over);
  return ends.R_map_from * turned.toRotationMatrix();
}

TEST(TurnCurve, IsWhatQuaternionsGiveInFinerSteps) {
  ImuErrors errors;
  errors.bias_radps = {0.05, -0.1, 0.2};
  errors.sigma_radps = 0.1;
  errors.step_ns = 4'900'000;  // rates and poses at times of their own
  const std::vector<TurnRate> rates = imu_of(jerky, 2.0, errors);
  for (int k = 0; k < 10; ++k) {
    const TurnEnds ends = ends_of(jerky, k * kTenth_ns, (k + 1) * kTenth_ns);
    const std::optional<TurnCurve> curve = TurnCurve::between(rates, ends);
    ASSERT_TRUE(curve.has_value());
    for (std::int64_t share = 1; share < 8; ++share) {
      const std::int64_t time_ns = ends.from_ns + share * 12'345'678;
      EXPECT_LT(angle_between_rad(curve->at(time_ns), by_quaternions(rates, ends, time_ns)), 2e-6);
    }
  }
}

TEST(TurnCurve, HasTheEndsOfThePosesToTheBit) {
  ImuErrors errors;
  errors.bias_radps = {1.0, 2.0, 3.0};
  const std::vector<TurnRate> rates = imu_of(jerky, 1.0, errors);
  for (const std::int64_t from_ns : {0, 33'333'333}) {
    const TurnEnds ends = ends_of(jerky, from_ns, from_ns + kTenth_ns);
    const std::optional<TurnCurve> curve = TurnCurve::between(rates, ends);
    ASSERT_TRUE(curve.has_value());
    EXPECT_EQ(curve->at(ends.from_ns), ends.R_map_from);
    EXPECT_EQ(curve->at(ends.to_ns), ends.R_map_to);
    // And comes to them without a step.
    EXPECT_LT(angle_between_rad(curve->at(ends.from_ns + 1), ends.R_map_from), 1e-7);
    EXPECT_LT(angle_between_rad(curve->at(ends.to_ns - 1), ends.R_map_to), 1e-7);
  }
}

TEST(TurnCurve, FollowsTheTruthWhateverTheBias) {
  for (const double bias : {0.0, 0.1}) {
    ImuErrors errors;
    errors.bias_radps = {bias, -bias, bias};
    const std::vector<TurnRate> rates = imu_of(jerky, 1.0, errors);
    const TurnEnds ends = ends_of(jerky, 0, kTenth_ns);
    const std::optional<TurnCurve> curve = TurnCurve::between(rates, ends);
    ASSERT_TRUE(curve.has_value());
    const Eigen::Matrix3d truth = jerky(0.05).linear();
    const Eigen::Quaterniond even =
        Eigen::Quaterniond(ends.R_map_from).slerp(0.5, Eigen::Quaterniond(ends.R_map_to));
    EXPECT_GT(angle_between_rad(even.toRotationMatrix(), truth), 0.005);
    EXPECT_LT(angle_between_rad(curve->at(50'000'000), truth), 1e-4);
    EXPECT_GT(curve->bend_rad(), 0.005);
  }
}

TEST(TurnCurve, BendsNowhereWhereTheVehicleTurnsEvenly) {
  const VehicleMotion even = [](double time_s) { return pose_at(0.0, 0.0, 0.5 * time_s); };
  const std::optional<TurnCurve> curve =
      TurnCurve::between(imu_of(even, 1.0), ends_of(even, 0, kTenth_ns));
  ASSERT_TRUE(curve.has_value());
  EXPECT_LT(curve->bend_rad(), 1e-9);
}

TEST(TurnCurve, IsNoneWhereRatesDoNotCoverTheTime) {
  const std::vector<TurnRate> all = imu_of(jerky, 1.0);
  const TurnEnds ends = ends_of(jerky, 0, kTenth_ns);
  const auto between = [&](std::int64_t first_ns, std::int64_t last_ns, std::int64_t hole_ns) {
    std::vector<TurnRate> rates;
    for (const TurnRate& rate : all) {
      const bool is_in_hole = rate.stamp_ns > 30'000'000 && rate.stamp_ns < 30'000'000 + hole_ns;
      if (rate.stamp_ns >= first_ns && rate.stamp_ns <= last_ns && !is_in_hole) {
        rates.push_back(rate);
      }
    }
    return TurnCurve::between(rates, ends).has_value();
  };
  EXPECT_TRUE(between(0, kTenth_ns, 0));
  EXPECT_FALSE(between(5'000'000, kTenth_ns, 0));
  EXPECT_FALSE(between(0, kTenth_ns - 5'000'000, 0));
  EXPECT_TRUE(between(0, kTenth_ns, 50'000'000));
  EXPECT_FALSE(between(0, kTenth_ns, 55'000'000));
  EXPECT_FALSE(TurnCurve::between({}, ends).has_value());
  EXPECT_FALSE(TurnCurve::between(std::span(all).first(1), ends).has_value());
}

}  // namespace
}  // namespace sightline
