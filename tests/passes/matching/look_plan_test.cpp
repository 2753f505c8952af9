#include "passes/matching/look_plan.h"

#include <gtest/gtest.h>
#include <cmath>
#include <cstring>
#include <limits>

#include "passes/matching/localizer.h"
#include "tests/passes/matching/allocation_counter.h"
#include "tests/passes/matching/random_scene.h"

namespace sightline {
namespace {

constexpr double kAlways = -std::numeric_limits<double>::infinity();
constexpr double kNever = std::numeric_limits<double>::infinity();

const Localizer& room_localizer() {
  static const Localizer kLocalizer = make_localizer(room_map(), options_for_samples());
  return kLocalizer;
}

Scan room_scan(std::uint64_t seed) {
  Scan scan;
  scan.points_m = room_points(seed, 6000, 0.02);
  return scan;
}

LookPlan room_plan(double doubt_above) {
  LookPlan plan;
  plan.first = *parse_look("30 m, 2000 returns, 60 points by normals, settle");
  plan.second = *parse_look("30 m, 6000 returns, 400 points by normals, settle");
  plan.test.weights[5] = 2.0;  // of how far the match moved along its loose direction
  plan.doubt_above = doubt_above;
  return plan;
}

PosePrediction prediction_beside_truth(double off_m) {
  PosePrediction prediction;
  prediction.T_map_vehicle.translation().x() = off_m;
  return prediction;
}

PlannedMatch localize_room(const LookPlan& plan, const PosePrediction& prediction,
                           const LookDeadline& deadline = {},
                           MatchKernel kernel = MatchKernel::kFastest) {
  const SensorProfile sensor;
  PlannedLocalizer planned{room_localizer(), sensor, plan};
  planned.options.kernel = kernel;
  LookMemory memory;
  return localize_in_looks(planned, room_scan(5), prediction, memory, deadline);
}

double error_m(const PlannedMatch& found) { return found.match.T_map_sensor.translation().norm(); }

TEST(LookPlan, AConfidentFirstLookRunsNoSecond) {
  const PlannedMatch found = localize_room(room_plan(kNever), prediction_beside_truth(0.1));
  EXPECT_EQ(found.look_count, 1);
  EXPECT_EQ(found.match.T_map_sensor.matrix(), found.T_map_first.matrix());
  EXPECT_LT(error_m(found), 0.05);
  EXPECT_EQ(found.match.work, 60U * static_cast<unsigned>(found.match.iterations));
}

TEST(LookPlan, ADoubtfulFirstLookRunsTheSecondAndItsResultStands) {
  const PlannedMatch first = localize_room(room_plan(kNever), prediction_beside_truth(0.1));
  const PlannedMatch found = localize_room(room_plan(kAlways), prediction_beside_truth(0.1));
  EXPECT_EQ(found.look_count, 2);
  EXPECT_EQ(found.T_map_first.matrix(), first.T_map_first.matrix());
  EXPECT_NE(found.match.T_map_sensor.matrix(), found.T_map_first.matrix());
  EXPECT_LT(error_m(found), 0.03);
}

TEST(LookPlan, IterationsAndWorkAreOfAllLooks) {
  const PosePrediction prediction = prediction_beside_truth(0.1);
  const PlannedMatch first = localize_room(room_plan(kNever), prediction);
  const PlannedMatch both = localize_room(room_plan(kAlways), prediction);
  LookCutter cutter;
  ScanForMatch cut;
  cutter.cut(room_localizer(), room_scan(5), {}, room_plan(kAlways).second,
             prediction.T_map_vehicle, cut);
  const MatchResult second =
      settle(room_localizer(), cut, prediction.T_map_vehicle, {.stop_step_m = kSampleStop_m});
  EXPECT_EQ(both.match.iterations, first.match.iterations + 11 + second.iterations);
  EXPECT_EQ(both.match.work, first.match.work + 11 * cut.thin_count + second.work);
}

TEST(LookPlan, TheThresholdDecidesWhichMatchesAreDoubted) {
  const double doubt = localize_room(room_plan(kNever), prediction_beside_truth(0.2)).doubt;
  EXPECT_EQ(localize_room(room_plan(doubt), prediction_beside_truth(0.2)).look_count, 1);
  EXPECT_EQ(localize_room(room_plan(doubt - 1e-9), prediction_beside_truth(0.2)).look_count, 2);
}

TEST(LookPlan, AVehicleThatDoesNotTrackSearchesWithTheSecondLookAlone) {
  PosePrediction prediction = prediction_beside_truth(0.6);
  prediction.is_tracking = false;
  const PlannedMatch found = localize_room(room_plan(kNever), prediction);
  EXPECT_EQ(found.look_count, 1);
  EXPECT_LT(error_m(found), 0.03);
  const SensorProfile sensor;
  LookCutter cutter;
  ScanForMatch cut;
  cutter.cut(room_localizer(), room_scan(5), sensor, room_plan(kNever).second,
             prediction.T_map_vehicle, cut);
  const MatchResult searched =
      localize(room_localizer(), cut, prediction.T_map_vehicle, {.stop_step_m = kSampleStop_m});
  EXPECT_EQ(found.match.T_map_sensor.matrix(), searched.T_map_sensor.matrix());
}

TEST(LookPlan, TheSecondLookFindsAVehicleThatTurnedFurtherThanForetold) {
  for (const double turn_deg : {-9.0, -6.0, 6.0, 9.0}) {
    PosePrediction prediction;
    prediction.T_map_vehicle.linear() =
        Eigen::AngleAxisd(turn_deg * std::acos(-1.0) / 180.0, Eigen::Vector3d::UnitZ())
            .toRotationMatrix();
    EXPECT_LT(error_m(localize_room(room_plan(kAlways), prediction)), 0.03) << turn_deg;
  }
}

TEST(LookPlan, NoLookBeginsPastTheDeadline) {
  double clock_ms = 0.0;
  int questions = 0;
  LookDeadline deadline;
  deadline.now_ms = [&] {
    ++questions;
    return clock_ms;
  };
  deadline.latest_ms = 10.0;
  clock_ms = 10.0;
  const PlannedMatch in_time =
      localize_room(room_plan(kAlways), prediction_beside_truth(0.1), deadline);
  EXPECT_EQ(in_time.look_count, 2);
  EXPECT_FALSE(in_time.is_past_deadline);
  clock_ms = 10.1;
  const PlannedMatch late =
      localize_room(room_plan(kAlways), prediction_beside_truth(0.1), deadline);
  EXPECT_EQ(late.look_count, 1);  // the first look is always had
  EXPECT_TRUE(late.is_past_deadline);
  EXPECT_EQ(late.match.T_map_sensor.matrix(), late.T_map_first.matrix());
  EXPECT_EQ(questions, 2);
  const PlannedMatch confident =
      localize_room(room_plan(kNever), prediction_beside_truth(0.1), deadline);
  EXPECT_FALSE(confident.is_past_deadline);
}

TEST(LookPlan, AllocatesNothingOnceItHasSeenSuchAScan) {
  const SensorProfile sensor;
  const LookPlan plan = room_plan(kAlways);
  const PlannedLocalizer planned{room_localizer(), sensor, plan};
  const Scan scan = room_scan(7);
  LookDeadline deadline;
  deadline.now_ms = [] { return 0.0; };
  deadline.latest_ms = 1.0;
  LookMemory memory;
  localize_in_looks(planned, scan, prediction_beside_truth(0.1), memory, deadline);
  const std::size_t before = allocation_count();
  const PlannedMatch found =
      localize_in_looks(planned, scan, prediction_beside_truth(0.1), memory, deadline);
  EXPECT_EQ(allocation_count(), before);
  EXPECT_EQ(found.look_count, 2);
}

TEST(LookPlan, AllKernelsGiveTheSameBytes) {
  const PlannedMatch expected =
      localize_room(room_plan(kAlways), prediction_beside_truth(0.2), {}, MatchKernel::kPortable);
  for (const MatchKernel kernel : {MatchKernel::kAvx2, MatchKernel::kAvx512}) {
    if (!is_supported(kernel)) continue;
    const PlannedMatch found =
        localize_room(room_plan(kAlways), prediction_beside_truth(0.2), {}, kernel);
    EXPECT_EQ(std::memcmp(found.match.T_map_sensor.data(), expected.match.T_map_sensor.data(),
                          16 * sizeof(double)),
              0);
    EXPECT_EQ(found.signs, expected.signs);
    EXPECT_EQ(found.doubt, expected.doubt);
  }
}

TEST(LookPlan, WhereNothingCanBeMatchedTheForetoldPoseStands) {
  const SensorProfile sensor;
  const LookPlan plan = room_plan(kNever);
  const PlannedLocalizer planned{room_localizer(), sensor, plan};
  LookMemory memory;
  const PosePrediction prediction = prediction_beside_truth(0.3);
  const PlannedMatch found = localize_in_looks(planned, Scan{}, prediction, memory);
  EXPECT_EQ(found.look_count, 2);  // a first look without a match is always doubted
  EXPECT_EQ(found.match.stop, MatchStop::kNoPoints);
  EXPECT_EQ(found.match.T_map_sensor.matrix(), prediction.T_map_vehicle.matrix());
}

TEST(LookPlan, ASecondLookThatSeesNothingLeavesTheFirstOnesPose) {
  LookPlan plan = room_plan(kAlways);
  plan.second.range_m = 0.5;
  const PlannedMatch found = localize_room(plan, prediction_beside_truth(0.1));
  EXPECT_EQ(found.look_count, 2);
  EXPECT_EQ(found.match.T_map_sensor.matrix(), found.T_map_first.matrix());
  EXPECT_EQ(found.match.stop, MatchStop::kConverged);
}

TEST(LookPlan, AMemoryKeepsNothingOfTheScanBefore) {
  const SensorProfile sensor;
  const LookPlan plan = room_plan(kAlways);
  const PlannedLocalizer planned{room_localizer(), sensor, plan};
  LookMemory memory;
  localize_in_looks(planned, room_scan(9), prediction_beside_truth(0.4), memory);
  const PlannedMatch found =
      localize_in_looks(planned, room_scan(5), prediction_beside_truth(0.1), memory);
  EXPECT_EQ(found.match.T_map_sensor.matrix(),
            localize_room(plan, prediction_beside_truth(0.1)).match.T_map_sensor.matrix());
}

MatchResult match_with(double along_x_per_m2, double along_y_per_m2) {
  MatchResult match;
  match.hessian.diagonal() << along_x_per_m2, along_y_per_m2, 100.0, 100.0, 100.0, 100.0;
  match.scored_points = 60;
  match.score = 300.0;
  match.nearest_voxel_likelihood = 3.0;
  return match;
}

TEST(LookTest, ReadsEightNumbersOffAMatch) {
  MatchResult match = match_with(400.0, 25.0);  // y is the loose direction: 0.2 m
  match.T_map_sensor.translation() = Eigen::Vector3d(0.03, -0.4, 0.04);
  match.T_map_sensor.linear() =
      Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const LookSigns signs = look_signs(match, 80, Pose::Identity());
  EXPECT_NEAR(signs[0], std::log(0.2), 1e-5);
  EXPECT_NEAR(signs[1], std::log(0.05), 1e-5);
  EXPECT_DOUBLE_EQ(signs[2], 0.75);
  EXPECT_DOUBLE_EQ(signs[3], 5.0);
  EXPECT_DOUBLE_EQ(signs[4], 3.0);
  EXPECT_NEAR(signs[5], std::log(0.41), 1e-9);
  EXPECT_NEAR(signs[6], std::log(0.06), 1e-9);
  EXPECT_NEAR(signs[7], std::log(0.021), 1e-9);
}

TEST(LookTest, SignsAreFiniteForAnyMatch) {
  Random random(5);
  for (int trial = 0; trial < 200; ++trial) {
    MatchResult match;
    for (double& value : match.hessian.reshaped()) value = random.uniform(-1e6, 1e6);
    match.hessian = (0.5 * (match.hessian + match.hessian.transpose())).eval();
    if (trial % 3 == 0) match.hessian.setZero();
    match.scored_points = static_cast<std::uint32_t>(random.below(3));
    match.T_map_sensor = random_pose(random, 100.0, 3.0);
    for (const double sign : look_signs(match, random.below(3), random_pose(random, 1.0, 3.0))) {
      EXPECT_TRUE(std::isfinite(sign));
    }
  }
  for (const double sign : look_signs({}, 0, Pose::Identity())) EXPECT_TRUE(std::isfinite(sign));
}

TEST(LookTest, SignsDoNotDependOnWhereInTheMapTheVehicleIs) {
  Random random(6);
  MatchResult match = match_with(400.0, 25.0);
  const Pose T_map_predicted = random_pose(random, 0.1, 0.1);
  const LookSigns here = look_signs(match, 80, T_map_predicted);
  Pose there = T_map_predicted;
  there.translation() += Eigen::Vector3d(512.0, 256.0, 0.0);
  match.T_map_sensor.translation() += Eigen::Vector3d(512.0, 256.0, 0.0);
  const LookSigns elsewhere = look_signs(match, 80, there);
  for (std::size_t i = 0; i < kLookSigns; ++i) EXPECT_NEAR(elsewhere[i], here[i], 1e-9);
}

}  // namespace
}  // namespace sightline
