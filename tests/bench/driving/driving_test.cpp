#include <gtest/gtest.h>
#include <cmath>

#include "formats/base/random.h"
#include "tests/bench/driving/learn_plan.h"

namespace sightline {
namespace {

// Looks that are off with odds exp(2 s3 - 1): sign 3 alone matters.
std::vector<LookExample> examples_by_third_sign(std::size_t count) {
  Random random(4);
  std::vector<LookExample> examples(count);
  for (LookExample& example : examples) {
    for (double& sign : example.signs) sign = random.uniform(-1.0, 3.0);
    const double p = 1.0 / (1.0 + std::exp(1.0 - 2.0 * example.signs[3]));
    example.is_off = example.is_beyond_limit = random.uniform(0.0, 1.0) < p;
  }
  return examples;
}

TEST(LearnLookTest, FindsTheWeightsThatMadeTheExamples) {
  const LookTest test = learn_look_test(examples_by_third_sign(20000));
  for (std::size_t i = 0; i < kLookSigns; ++i) {
    EXPECT_NEAR(test.weights[i], i == 3 ? 2.0 : 0.0, 0.1) << i;
  }
  EXPECT_NEAR(test.constant, -1.0, 0.1);
}

TEST(LearnLookTest, ASignThatHardlyVariesIsNotDecisive) {
  std::vector<LookExample> examples(1000);
  for (std::size_t i = 0; i < examples.size(); ++i) {
    examples[i].is_off = i % 50 == 0;
    examples[i].signs[2] = examples[i].is_off ? 0.9999 : 1.0;
  }
  EXPECT_LT(std::abs(learn_look_test(examples).weights[2]) * 1e-4, 0.1);
}

TEST(AreaUnderCurve, CountsPairsInTheirOrderAndEqualOnesHalf) {
  LookTest test;
  test.weights[0] = 1.0;
  const auto look = [](double sign, bool is_beyond) {
    LookExample example;
    example.signs[0] = sign;
    example.is_beyond_limit = is_beyond;
    return example;
  };
  const std::vector<LookExample> in_order = {look(1, false), look(2, false), look(3, true)};
  EXPECT_DOUBLE_EQ(area_under_curve(in_order, test), 1.0);
  const std::vector<LookExample> mixed = {look(1, true), look(2, false), look(3, true),
                                          look(3, false)};
  EXPECT_DOUBLE_EQ(area_under_curve(mixed, test), 1.5 / 4.0);
  EXPECT_DOUBLE_EQ(area_under_curve(mixed, LookTest{}), 0.5);
}

// A vehicle that finds the predicted pose, moved by this.
class MovedBy : public Vehicle {
 public:
  explicit MovedBy(double off_m) : off_m_(off_m) {}
  PlannedMatch localize(const Scan&, const PosePrediction& prediction) override {
    tracked.push_back(prediction.is_tracking);
    PlannedMatch found;
    found.match.T_map_sensor = prediction.T_map_vehicle;
    found.match.T_map_sensor.translation().z() += off_m_;
    return found;
  }
  std::vector<bool> tracked;

 private:
  double off_m_;
};

TEST(ClosedLoop, TracksFromTheThirdScanAndBeginsAnewWhereItIsLost) {
  TownDrive drive;
  for (int i = 0; i < 12; ++i) {
    drive.scans.emplace_back();
    drive.T_map_vehicle.push_back(Pose::Identity());
  }
  MovedBy vehicle(0.3);  // each step adds to the motion that is predicted: lost sooner or later
  const std::vector<DriveStep> steps = drive_whole(drive, vehicle);
  EXPECT_FALSE(vehicle.tracked[0]);
  EXPECT_FALSE(vehicle.tracked[1]);
  std::size_t lost = 0;
  for (std::size_t i = 0; i + 2 < steps.size(); ++i) {
    EXPECT_EQ(steps[i].is_lost, steps[i].error_m > 1.0);
    EXPECT_EQ(steps[i].is_tracking, vehicle.tracked[i]);
    if (!steps[i].is_lost) continue;
    ++lost;
    EXPECT_FALSE(vehicle.tracked[i + 1]);
  }
  EXPECT_GT(lost, 0U);
}

}  // namespace
}  // namespace sightline
