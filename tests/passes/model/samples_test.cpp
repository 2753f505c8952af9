#include <gtest/gtest.h>

#include "passes/model/choose_ranges.h"
#include "passes/model/forest/predict_error.h"
#include "passes/model/train_model.h"
#include "tests/support/synthetic_places.h"
#include "tests/support/test_context.h"

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

struct Street {
  Sites sites;
  ByFamily<FactorTable> factors;
  ByFamily<MeasuredError> measured;
};

Street street_of(const SyntheticDrive& drive) {
  return {drive.sites, drive.factors, drive.measured};
}

Street by_both() {
  Street street = street_of(by_ranges());
  SyntheticDrive samples = by_samples();
  samples.factors.factors.back() = "own_error";
  street.factors.samples = samples.factors;
  street.measured.samples = samples.measured;
  return street;
}

ByFamily<ErrorModel> model_of(const Street& street) {
  const TrainModelOptions options{.trees = 20};
  return value_of(train_model_here(TestContext(), options, street.sites, street.factors,
                                   street.measured, synthetic_recordings(0)));
}

ByFamily<PredictedError> predicted_by(const ByFamily<ErrorModel>& model, const Street& street) {
  return value_of(predict_error(TestContext(), {}, model, street.sites, street.factors,
                                synthetic_recordings(0)));
}

TEST(Samples, AreLearntBesideTheRangesAndChangeNothingOfThem) {
  const ByFamily<ErrorModel> both = model_of(by_both());
  ASSERT_TRUE(validate(both).has_value());
  ASSERT_TRUE(both.samples.has_value());
  EXPECT_EQ(to_bytes(both.ranges), to_bytes(model_of(street_of(by_ranges())).ranges));
  SyntheticDrive samples = by_samples();
  samples.factors.factors.back() = "own_error";
  ErrorModel alone = model_of(street_of(samples)).ranges;
  for (std::size_t site = 0; site < alone.sites.size(); ++site) {
    // The factors of ranges show what kind of place it is.
    ASSERT_EQ(both.samples->sites[site].kind, both.ranges.sites[site].kind) << site;
    alone.sites[site].kind = both.ranges.sites[site].kind;
  }
  alone.kinds = both.samples->kinds;
  EXPECT_EQ(to_bytes(*both.samples), to_bytes(alone));
}

TEST(Samples, AreNotLearntWhereAPlaceKnowsNothingOfThem) {
  Street street = by_both();
  street.measured.samples.reset();
  EXPECT_FALSE(model_of(street).samples.has_value());
}

TEST(Samples, ArePredictedByTheirOwnModel) {
  const Street street = by_both();
  const ByFamily<ErrorModel> model = model_of(street);
  const ByFamily<PredictedError> predicted = predicted_by(model, street);
  ASSERT_TRUE(validate(predicted).has_value());
  ASSERT_TRUE(predicted.samples.has_value());
  EXPECT_EQ(predicted.samples->looks, three_looks());
  Street samples = street;
  samples.factors = *street.factors.samples;
  EXPECT_EQ(to_bytes(*predicted.samples), to_bytes(predicted_by(*model.samples, samples).ranges));
}

// What is seen 100 m away may be another thing where all within the ranges is as it was.
TEST(Samples, AndRangesKnowASiteAsTheModelsOwnOrNeitherDoes) {
  Street street = by_both();
  const ByFamily<ErrorModel> model = model_of(street);
  FactorTable& ranges = street.factors.ranges;
  FactorTable& samples = *street.factors.samples;
  samples.values[samples.shape().size(5)] += 0.01;
  ranges.values[ranges.shape().size(9)] += 0.01;
  const ByFamily<PredictedError> predicted = predicted_by(model, street);
  std::vector<std::uint8_t> own(kSmall.site_count, 1);
  own[5] = own[9] = 0;
  EXPECT_EQ(predicted.ranges.out_of_fold, own);
  EXPECT_EQ(predicted.samples->out_of_fold, own);
}

TEST(Samples, AreChosenFromTheirOwnPredictions) {
  const Street street = by_both();
  const ByFamily<ErrorModel> model = model_of(street);
  const ByFamily<PredictedError> predicted = predicted_by(model, street);
  PassContext ctx;
  const ByFamily<RangeTable> table =
      value_of(choose_ranges(ctx, {}, street.sites, predicted, model, street.factors));
  ASSERT_TRUE(validate(table).has_value());
  ASSERT_TRUE(table.samples.has_value());
  const ByFamily<RangeTable> alone = value_of(choose_ranges(
      ctx, {}, street.sites, *predicted.samples, *model.samples, *street.factors.samples));
  EXPECT_EQ(to_bytes(*table.samples), to_bytes(alone.ranges));
}

TEST(Samples, ThatTheModelKnowsNothingOfAreRefused) {
  const Street street = by_both();
  ByFamily<ErrorModel> model = model_of(street);
  const ByFamily<PredictedError> predicted = predicted_by(model, street);
  model.samples.reset();
  EXPECT_EQ(
      failure_of(choose_ranges(TestContext(), {}, street.sites, predicted, model, street.factors))
          .code,
      ErrorCode::kMismatchedInputs);
}

TEST(Samples, KeepToTheirOwnTable) {
  ByFamily<PredictedError> predicted = predicted_by(model_of(by_both()), by_both());
  predicted.samples->looks = predicted.ranges.looks;
  EXPECT_FALSE(validate(predicted).has_value()) << "a range among the samples";
}

}  // namespace
}  // namespace sightline
