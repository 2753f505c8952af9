#include "passes/model/choose_tracking_looks.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "passes/model/train_model.h"
#include "tests/support/synthetic_places.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

const SyntheticOptions kSmall = {
    .site_count = 150, .ranges_m = {10.0, 20.0, 30.0}, .has_paper_factors = false};

struct Street {
  Sites sites;
  ByFamily<FactorTable> factors;
  ByFamily<MeasuredError> measured;
};

// From each tracking start a match ends so far off as a share of the error from acquiring starts.
void add_tracking(float share, MeasuredError& measured) {
  measured.tracking_offsets.assign(5, InitialOffset{});
  measured.tracking_ends.clear();
  for (const ErrorRow& row : measured.rows) {
    const AxisErrors end{share * static_cast<float>(row.mean_m), 0.0F, 0.0F, 0.0F};
    measured.tracking_ends.insert(measured.tracking_ends.end(), measured.tracking_offsets.size(),
                                  end);
  }
}

Street street(float tracking_share) {
  SyntheticDrive ranges = synthetic_drive(1, kSmall);
  SyntheticDrive samples = synthetic_drive(2, kSmall);
  ranges.factors.factors.back() = samples.factors.factors.back() = "own_error";
  samples.factors.looks = {{.range_m = 100.0, .return_count = 650, .point_count = 40},
                           {.range_m = 100.0, .return_count = 1944, .point_count = 80},
                           {.range_m = 100.0, .return_count = 4000, .point_count = 128}};
  samples.measured.looks = samples.factors.looks;
  add_tracking(tracking_share, ranges.measured);
  add_tracking(tracking_share, samples.measured);
  Street made{ranges.sites, ranges.factors, ranges.measured};
  made.factors.samples = samples.factors;
  made.measured.samples = samples.measured;
  return made;
}

ByFamily<ErrorModel> model_of(const Street& street) {
  const TrainModelOptions options{.trees = 20};
  return value_of(train_model_here(TestContext(), options, street.sites, street.factors,
                                   street.measured, synthetic_recordings(0)));
}

TrackingLooks looks_of(const Street& street, const ByFamily<ErrorModel>& model,
                       const ChooseTrackingLooksOptions& options = {}) {
  return value_of(choose_tracking_looks(TestContext(), options, street.sites, model, street.factors,
                                        synthetic_recordings(0), &street.measured));
}

std::size_t answered_count(const TrackingLooks& looks, std::size_t limit) {
  return static_cast<std::size_t>(std::ranges::count_if(
      looks.columns[2 * limit].values, [](float number) { return number >= 0.0F; }));
}

TEST(ChooseTrackingLooks, LearnsTheErrorsFromTrackingStartsOfLooksThatTakeASample) {
  const Street half = street(0.5F);
  const ByFamily<ErrorModel> model = model_of(half);
  ASSERT_TRUE(validate(model).has_value());
  EXPECT_TRUE(model.ranges.tracking.is_empty());
  const ErrorModel& looks = *model.samples;
  ASSERT_EQ(looks.tracking.measured_m.size(), looks.measured_mean_m.size());
  for (std::size_t row = 0; row < looks.measured_mean_m.size(); ++row) {
    ASSERT_NEAR(looks.tracking.measured_m[row], 0.5 * looks.measured_mean_m[row], 1.0 / 8192.0);
  }
  for (std::size_t row = 0; row < looks.forest.labels.size(); ++row) {
    ASSERT_NEAR(looks.tracking.row_errors_m[row], 0.5 * looks.forest.labels[row], 1.0 / 8192.0);
  }
  const ErrorModel of_tracking = tracking_model(looks);
  for (std::size_t row = 0; row < looks.out_of_fold.mean_m.size(); ++row) {
    ASSERT_NEAR(of_tracking.out_of_fold.mean_m[row], 0.5 * looks.out_of_fold.mean_m[row],
                1.0 / 1024.0);
  }
}

TEST(ChooseTrackingLooks, AnswersEverySiteByTheCheapestLookWhereTrackingAlwaysHolds) {
  const Street easy = street(0.001F);
  const TrackingLooks looks = looks_of(easy, model_of(easy));
  ASSERT_TRUE(validate(looks).has_value());
  ASSERT_EQ(looks.columns.size(), 4u);
  EXPECT_EQ(looks.columns[0].name, "tracking_look_0");
  EXPECT_EQ(looks.columns[3].name, "tracking_probability_1");
  for (std::size_t site = 0; site < kSmall.site_count; ++site) {
    EXPECT_EQ(looks.columns[0].values[site], 0.0F) << site;
    EXPECT_GT(looks.columns[1].values[site], 0.95F) << site;
  }
}

TEST(ChooseTrackingLooks, AnswersFewerSitesWhereTrackingErrorsAreLarger) {
  std::size_t before = kSmall.site_count;
  for (const float share : {0.01F, 1.0F, 20.0F}) {
    const Street here = street(share);
    const std::size_t now = answered_count(looks_of(here, model_of(here)), 0);
    EXPECT_LE(now, before) << share;
    before = now;
  }
  EXPECT_LT(before, kSmall.site_count / 2);
}

TEST(ChooseTrackingLooks, ChoosesNoneWithoutSuchErrorsOrByTheMeanRule) {
  Street silent = street(0.5F);
  const ByFamily<ErrorModel> model = model_of(silent);
  ChooseTrackingLooksOptions by_mean;
  by_mean.choice.selection = Selection::kMean;
  EXPECT_TRUE(looks_of(silent, model, by_mean).columns.empty());
  silent.measured.samples->tracking_offsets.clear();
  silent.measured.samples->tracking_ends.clear();
  const ByFamily<ErrorModel> without = model_of(silent);
  EXPECT_TRUE(without.samples->tracking.is_empty());
  EXPECT_TRUE(looks_of(silent, without).columns.empty());
  EXPECT_EQ(looks_of(silent, model).columns.size(), 4u) << "the evidence is of the model's sites";
}

TEST(ChooseTrackingLooks, RefusesOtherFactorsAndTornLabels) {
  Street here = street(0.5F);
  ByFamily<ErrorModel> model = model_of(here);
  Street other = here;
  other.factors.samples->looks[0].return_count = 700;
  EXPECT_EQ(failure_of(choose_tracking_looks(TestContext(), {}, other.sites, model, other.factors,
                                             synthetic_recordings(0), &other.measured))
                .code,
            ErrorCode::kMismatchedInputs);
  model.samples->tracking.mean_m.pop_back();
  EXPECT_FALSE(validate(model).has_value());
}

}  // namespace
}  // namespace sightline
