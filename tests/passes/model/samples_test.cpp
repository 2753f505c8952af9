#include <gtest/gtest.h>

#include "passes/model/choose_ranges.h"
#include "passes/model/forest/predict_error.h"
#include "passes/model/train_model.h"
#include "tests/support/synthetic_places.h"
#include "tests/support/test_context.h"
#include "tests/support/train_on_place.h"

// Looks that take a sample are learnt, predicted and chosen by the same code as ranges, each table
// in its turn: neither changes the other.

namespace sightline {
namespace {

const SyntheticOptions kSmall = {
    .site_count = 150, .ranges_m = {10.0, 20.0, 30.0}, .has_paper_factors = false};

std::vector<Look> three_looks() {
  return {{.range_m = 100.0, .return_count = 650, .point_count = 40},
          {.range_m = 100.0, .return_count = 1944, .point_count = 80},
          {.range_m = 100.0, .return_count = 4000, .point_count = 128}};
}

// The same street, as three looks find it.
SyntheticDrive by_samples() {
  SyntheticDrive drive = synthetic_drive(2, kSmall);
  drive.sites = synthetic_drive(1, kSmall).sites;
  drive.factors.looks = drive.measured.looks = three_looks();
  return drive;
}

SyntheticDrive by_ranges() {
  SyntheticDrive drive = synthetic_drive(1, kSmall);
  drive.factors.factors.back() = "own_error";
  return drive;
}

SyntheticDrive by_both() {
  SyntheticDrive drive = by_ranges();
  SyntheticDrive samples = by_samples();
  samples.factors.factors.back() = "own_error";
  drive.factors.of_samples = {samples.factors};
  drive.measured.of_samples = {samples.measured};
  return drive;
}

ErrorModel model_of(const SyntheticDrive& drive) {
  TrainModelOptions options;
  options.trees = 20;
  return value_of(train_on_place(TestContext(), options, place_of(drive)));
}

PredictedError predicted_by(const ErrorModel& model, const SyntheticDrive& drive) {
  return value_of(
      predict_error(TestContext(), {}, model, drive.sites, drive.factors, synthetic_recordings(0)));
}

TEST(Samples, AreLearntBesideTheRangesAndChangeNothingOfThem) {
  const ErrorModel both = model_of(by_both());
  ASSERT_TRUE(validate(both).has_value());
  ASSERT_EQ(both.of_samples.size(), 1U);
  ErrorModel ranges = both;
  ranges.of_samples.clear();
  EXPECT_EQ(to_bytes(ranges), to_bytes(model_of(by_ranges())));
  SyntheticDrive samples = by_samples();
  samples.factors.factors.back() = "own_error";
  EXPECT_EQ(to_bytes(both.of_samples.front()), to_bytes(model_of(samples)));
}

TEST(Samples, AreNotLearntWhereAPlaceKnowsNothingOfThem) {
  SyntheticDrive drive = by_both();
  drive.measured.of_samples.clear();
  EXPECT_TRUE(model_of(drive).of_samples.empty());
}

TEST(Samples, ArePredictedByTheirOwnModel) {
  const SyntheticDrive drive = by_both();
  const ErrorModel model = model_of(drive);
  const PredictedError predicted = predicted_by(model, drive);
  ASSERT_TRUE(validate(predicted).has_value());
  ASSERT_EQ(predicted.of_samples.size(), 1U);
  EXPECT_EQ(predicted.of_samples.front().looks, three_looks());
  SyntheticDrive samples = drive;
  samples.factors = drive.factors.of_samples.front();
  EXPECT_EQ(to_bytes(predicted.of_samples.front()),
            to_bytes(predicted_by(model.of_samples.front(), samples)));
}

// What is seen 100 m away may be another thing where all within the ranges is as it was.
TEST(Samples, AndRangesKnowASiteAsTheModelsOwnOrNeitherDoes) {
  SyntheticDrive drive = by_both();
  const ErrorModel model = model_of(drive);
  FactorTable& samples = drive.factors.of_samples.front();
  samples.values[samples.shape().size(5)] += 0.01;
  drive.factors.values[drive.factors.shape().size(9)] += 0.01;
  const PredictedError predicted = predicted_by(model, drive);
  std::vector<std::uint8_t> own(kSmall.site_count, 1);
  own[5] = own[9] = 0;
  EXPECT_EQ(predicted.out_of_fold, own);
  EXPECT_EQ(predicted.of_samples.front().out_of_fold, own);
}

TEST(Samples, AreChosenFromTheirOwnPredictions) {
  const SyntheticDrive drive = by_both();
  const ErrorModel model = model_of(drive);
  const PredictedError predicted = predicted_by(model, drive);
  PassContext ctx;
  const RangeTable table =
      value_of(choose_ranges(ctx, {}, drive.sites, predicted, model, drive.factors));
  ASSERT_TRUE(validate(table).has_value());
  ASSERT_EQ(table.of_samples.size(), 1U);
  const RangeTable alone =
      value_of(choose_ranges(ctx, {}, drive.sites, predicted.of_samples.front(),
                             model.of_samples.front(), drive.factors.of_samples.front()));
  EXPECT_EQ(to_bytes(table.of_samples.front()), to_bytes(alone));
}

TEST(Samples, ThatTheModelKnowsNothingOfAreRefused) {
  const SyntheticDrive drive = by_both();
  ErrorModel model = model_of(drive);
  const PredictedError predicted = predicted_by(model, drive);
  model.of_samples.clear();
  EXPECT_EQ(
      failure_of(choose_ranges(TestContext(), {}, drive.sites, predicted, model, drive.factors))
          .code,
      ErrorCode::kMismatchedInputs);
}

TEST(Samples, KeepToTheirOwnTable) {
  PredictedError predicted = predicted_by(model_of(by_both()), by_both());
  predicted.of_samples.front().looks = predicted.looks;
  EXPECT_FALSE(validate(predicted).has_value()) << "a range among the samples";
  PredictedError twice = predicted_by(model_of(by_both()), by_both());
  twice.of_samples.push_back(twice.of_samples.front());
  EXPECT_FALSE(validate(twice).has_value());
}

}  // namespace
}  // namespace sightline
