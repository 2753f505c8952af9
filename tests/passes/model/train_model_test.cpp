#include "passes/model/train_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>
#include <vector>

#include "formats/model/place_count.h"
#include "passes/model/forest/growing/feature_rows.h"
#include "tests/support/synthetic_places.h"
#include "tests/support/test_context.h"
#include "tests/support/train_on_place.h"
#include "tests/support/whole_rows.h"

namespace sightline {
namespace {

const SyntheticOptions kSmall = {
    .site_count = 200, .ranges_m = {10.0, 20.0, 30.0}, .has_paper_factors = false};

TrainModelOptions quick() {
  TrainModelOptions options{.trees = 20};
  return options;
}

Result<ErrorModel> train(const SyntheticDrive& drive, const TrainModelOptions& options = quick(),
                         int threads = 1) {
  return train_on_place(TestContext(threads), options, place_of(drive));
}

TEST(TrainModel, LearnsFromEverySiteWithAScanAtEveryRange) {
  SyntheticDrive drive = synthetic_drive(1, kSmall);
  drive.measured.scan_of_site[7] = -1;
  for (std::size_t range = 0; range < 3; ++range) drive.measured.rows[7 * 3 + range] = ErrorRow{};
  const ErrorModel model = value_of(train(drive));
  require(validate(model));
  EXPECT_EQ(model.forest.labels.size(), 199u * 3u);
  EXPECT_EQ(model.forest.trees.size(), 20u);
  EXPECT_EQ(model.card.block_count, 3u);
  EXPECT_EQ(model.card.fold_count, 3u);
  EXPECT_EQ(model.sites[7].has_label, 0);
  EXPECT_EQ(model.features.back().name, "range_m");
  EXPECT_EQ(model.features.back().support_min, (std::vector<double>{10.0, 20.0, 30.0}));
}

TEST(TrainModel, PredictsPlacesItsTreesNeverSaw) {
  SyntheticOptions synthetic = kSmall;
  synthetic.site_count = 400;
  const ErrorModel model = value_of(train(synthetic_drive(2, synthetic)));
  for (const RangeCard& range : model.ranges) {
    EXPECT_GT(range.r_squared, 0.2);
    EXPECT_LT(range.r_squared, 0.95);  // the noise of the errors cannot be known
  }
}

TEST(TrainModel, NeverShowsAFoldItsOwnLabels) {
  // Labels that are pure noise: only a forest that saw them can predict them.
  SyntheticDrive drive = synthetic_drive(3, kSmall);
  Random random(9);
  for (ErrorRow& row : drive.measured.rows) row.mean_m = random.uniform();
  const ErrorModel model = value_of(train(drive));
  for (const RangeCard& range : model.ranges) EXPECT_LT(range.r_squared, 0.1);
}

TEST(TrainModel, NeverShowsADriveItsOwnLabels) {
  // Two drives of one place that found quite different errors: trees of the one say its own.
  DrivenPlaces places = places_driven_twice(1, kSmall);
  const auto set_errors = [](MeasuredError& drive, double mean_m) {
    for (ErrorRow& row : drive.rows) row.mean_m = mean_m;
  };
  set_errors(places.places[0].drives[0], 0.1);
  set_errors(places.places[0].drives[1], 0.9);
  const ErrorModel model = value_of(of_ranges(train_model(TestContext(), quick(), places)));
  EXPECT_EQ(model.card.hold_out, "drives");
  ASSERT_TRUE(validate(model).has_value());
  for (std::size_t i = 0; i < model.sites.size(); ++i) {
    EXPECT_NEAR(model.out_of_fold.mean(i, 0), model.sites[i].drive == 0 ? 0.9 : 0.1, 1e-9);
  }
}

TEST(TrainModel, LearnsFromManyPlacesAndJudgesEachByTheOthers) {
  const DrivenPlaces places = places_driven_twice(3, kSmall);
  const ErrorModel model = value_of(of_ranges(train_model(TestContext(), quick(), places)));
  require(validate(model));
  EXPECT_EQ(model.card.hold_out, "places");
  ASSERT_EQ(model.card.places.size(), 3u);
  EXPECT_EQ(model.card.places[2].drives, (std::vector<std::string>{"synthetic", "again"}));
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(model.card.places[i].recordings, places.places[i].recordings);
  }
  EXPECT_EQ(model.card.block_count, 9u);
  EXPECT_TRUE(model.card.knows_history);
  EXPECT_EQ(model.sites.size(), 3u * 4u * 200u);
  EXPECT_NE(to_text(model).find("3 folds of whole places; with earlier drives"), std::string::npos);
}

TEST(TrainModel, KnowsAPlaceBetterWhereAnEarlierDriveToldOfIt) {
  const ErrorModel model =
      value_of(of_ranges(train_model(TestContext(), quick(), places_driven_twice(3, kSmall))));
  for (const RangeCard& range : model.ranges) {
    EXPECT_GT(range.history_r_squared, 0.7) << range.range_m;  // the noise between drives is 10 %
    EXPECT_GT(range.history_r_squared, range.r_squared);
  }
}

TEST(TrainModel, LearnsFromFewerSitesWhereRowsAreTooMany) {
  TrainModelOptions options = quick();
  options.most_rows = 1000;
  const ErrorModel model =
      value_of(of_ranges(train_model(TestContext(), options, places_driven_twice(2, kSmall))));
  EXPECT_LE(model.forest.labels.size(), 1000u);
  EXPECT_GE(model.forest.labels.size(), 700u);
  EXPECT_TRUE(validate(model).has_value());
}

TEST(TrainModel, FindsTheFactorThatMatters) {
  SyntheticDrive drive = synthetic_drive(4, kSmall);
  const std::size_t factor_count = drive.factors.factors.size();
  for (std::size_t i = 0; i < drive.measured.rows.size(); ++i) {
    drive.measured.rows[i].mean_m = drive.factors.values[i * factor_count + 1] > 0.5 ? 0.4 : 0.05;
  }
  const ErrorModel model = value_of(train(drive));
  for (std::size_t i = 0; i < model.features.size(); ++i) {
    if (i == 1) continue;
    EXPECT_GT(model.features[1].importance_m, 4.0 * model.features[i].importance_m);
  }
}

TEST(TrainModel, GivesTheSameBytesForAnyThreadCount) {
  const SyntheticDrive drive = synthetic_drive(5, kSmall);
  const ErrorModel one = value_of(train(drive, quick(), 1));
  EXPECT_EQ(to_bytes(one), to_bytes(value_of(train(drive, quick(), 2))));
}

TEST(TrainModel, LearnsFromThePapersFactorsAloneWhereAsked) {
  SyntheticOptions synthetic = kSmall;
  synthetic.has_paper_factors = true;
  TrainModelOptions options = quick();
  options.features = FeatureSet::kPaper;
  const ErrorModel model = value_of(train(synthetic_drive(1, synthetic), options));
  ASSERT_EQ(model.features.size(), 12u);
  for (std::size_t i = 0; i < 11; ++i) EXPECT_EQ(model.features[i].name, paper_factors()[i]);
}

TEST(TrainModel, SaysThatOnePlaceAloneIsNoPromiseOfOthers) {
  DrivenPlaces places = places_driven_twice(1, kSmall);
  std::string warnings;
  PassContext ctx;
  ctx.warning_sink = [&](const std::string& message) { warnings += message; };
  ASSERT_TRUE(train_model(ctx, quick(), places).has_value());
  EXPECT_NE(warnings.find("trained on one place"), std::string::npos) << warnings;
}

TEST(TrainModel, CountsItsProgressOverBothFamiliesOfLooks) {
  ByFamily<DrivenPlaces> places(places_driven_twice(2, kSmall));
  places.samples = places.ranges;
  std::vector<std::size_t> done;
  std::set<std::size_t> totals;
  PassContext ctx;
  ctx.progress_sink = [&](std::size_t count, std::size_t total) {
    done.push_back(count);
    totals.insert(total);
  };
  ASSERT_TRUE(train_model(ctx, quick(), places).has_value());
  EXPECT_EQ(totals.size(), 1U);
  EXPECT_TRUE(std::ranges::is_sorted(done));
  EXPECT_EQ(done.back() + 1, *totals.begin()) << "the last forest is counted by nothing";
}

TEST(TrainModel, CountsACopyAsTheSamePlace) {
  DrivenPlaces places = places_driven_twice(1, kSmall);
  places.places.push_back(places.places.front());
  places.places.back().name = "copy";
  std::string warnings;
  PassContext ctx;
  ctx.warning_sink = [&](const std::string& message) { warnings += message; };
  const auto model = train_model(ctx, quick(), places);
  ASSERT_TRUE(model.has_value());
  const std::string one = "1 place (copy is the same place as " + places.places[0].name + ")";
  EXPECT_EQ(places_text(model->ranges.card), one);
  EXPECT_NE(warnings.find("the model is trained on " + one), std::string::npos) << warnings;
  EXPECT_NE(to_text(*model).find("\n" + one + "; "), std::string::npos) << to_text(*model);
  const auto two = train_model(ctx, quick(), places_driven_twice(2, kSmall));
  EXPECT_EQ(places_text(two.value().ranges.card), "2 places");
}

TEST(TrainModel, SaysWhatTheMeanRuleReachesInEachTypeOfStreet) {
  DrivenPlaces places = places_driven_twice(2, kSmall);
  for (DrivenPlace& place : places.places) {  // lanes, then open places
    for (std::size_t row = 0; row < place.factors.site_count * place.factors.looks.size(); ++row) {
      const bool is_lane = row < place.factors.values.size() / (2 * place.factors.factors.size());
      place.factors.values[row * place.factors.factors.size() + 1] = is_lane ? 0.9 : 0.1;
    }
  }
  const ErrorModel model = value_of(of_ranges(train_model(TestContext(), quick(), places)));
  ASSERT_EQ(model.kinds.size(), 4u) << "two types at two limits";
  EXPECT_EQ(model.kinds[0].kind, PlaceKind::kLane);
  EXPECT_EQ(model.kinds[1].kind, PlaceKind::kOpen);
  EXPECT_EQ(model.kinds[0].case_count + model.kinds[1].case_count, 2 * 2 * kSmall.site_count);
  for (const KindCard& card : model.kinds) {
    EXPECT_GT(card.coverage, 0.2);
    EXPECT_LE(card.coverage, 1.0);
  }
}

TEST(TrainModel, NamesFactorsThatNeverVary) {
  SyntheticDrive drive = synthetic_drive(1, kSmall);
  for (std::size_t i = 0; i < drive.factors.values.size(); i += 3) drive.factors.values[i] = 4.0;
  TestContext ctx;
  ASSERT_TRUE(train_on_place(ctx, quick(), place_of(drive)).has_value());
  ASSERT_EQ(ctx.warnings.size(), 1u);
  EXPECT_NE(ctx.warnings[0].find("feature_count"), std::string::npos);
}

TEST(TrainModel, RefusesADriveTooShortToHoldAnythingOut) {
  SyntheticOptions synthetic = kSmall;
  synthetic.site_count = 25;
  EXPECT_EQ(failure_of(train(synthetic_drive(1, synthetic))).code, ErrorCode::kDriveTooShort);
}

TEST(TrainModel, JudgesAShortDriveOnShorterBlocksAndSaysSo) {
  SyntheticOptions synthetic = kSmall;
  synthetic.site_count = 72;
  const SyntheticDrive drive = synthetic_drive(1, synthetic);
  TestContext ctx;
  const ErrorModel model = value_of(train_on_place(ctx, quick(), place_of(drive)));
  EXPECT_GE(model.card.block_count, 2u);
  EXPECT_GE(model.card.block_m, 15.0);
  EXPECT_LT(model.card.block_m, 60.0);
  EXPECT_LE(model.card.buffer_m, model.card.block_m / 2.0);
  ASSERT_EQ(ctx.warnings.size(), 1u);
  EXPECT_NE(ctx.warnings[0].find("too short"), std::string::npos);
}

TEST(TrainModel, LearnsNothingFromADirection) {
  SyntheticDrive drive = synthetic_drive(1, kSmall);
  drive.factors.factors[0] = "crlb_heading";
  const ErrorModel model = value_of(train_on_place(TestContext(), quick(), place_of(drive)));
  for (const FeatureCard& feature : model.features) EXPECT_NE(feature.name, "crlb_heading");
}

TEST(TrainModel, RefusesABufferThatLeavesNothingToLearnFrom) {
  TrainModelOptions options = quick();
  options.buffer_m = 500.0;
  const Error refused = failure_of(train(synthetic_drive(1, kSmall), options));
  EXPECT_EQ(refused.code, ErrorCode::kDriveTooShort);
  EXPECT_NE(refused.message.find("500 m"), std::string::npos);
}

TEST(TrainModel, SimulatedErrorsTeachItNothing) {
  SyntheticDrive drive = synthetic_drive(1, kSmall);
  drive.factors.factors.back() = "own_error";
  ASSERT_EQ(train(drive)->card.tree_count, 20U);
  drive.measured.reference = ErrorReference::kSimulated;
  const ErrorModel model = value_of(train(drive));
  ASSERT_TRUE(validate(model).has_value());
  EXPECT_EQ(model.card.feature_set, "none");
  EXPECT_EQ(model.card.reference, ErrorReference::kSimulated);
  EXPECT_EQ(model.measured(5, 2), drive.factors.at(5, 2, drive.factors.factors.size() - 1));
}

TEST(TrainModel, RefusesADriveWithoutErrors) {
  SyntheticDrive drive = synthetic_drive(1, kSmall);
  drive.measured.scan_of_site.assign(kSmall.site_count, -1);
  drive.measured.rows.assign(drive.measured.rows.size(), ErrorRow{});
  EXPECT_EQ(failure_of(train(drive)).code, ErrorCode::kNoTrainingRows);
}

TEST(TrainModel, RefusesNumbersThatAreNone) {
  SyntheticDrive drive = synthetic_drive(1, kSmall);
  drive.measured.rows[4].mean_m = std::numeric_limits<double>::quiet_NaN();
  const Error refused = failure_of(train(drive));
  EXPECT_EQ(refused.code, ErrorCode::kInvalidArtifact);
  EXPECT_EQ(refused.place, "site 1, range 1");
  drive = synthetic_drive(1, kSmall);
  drive.factors.values[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(failure_of(train(drive)).code, ErrorCode::kInvalidArtifact);
}

TEST(TrainModel, NamesOtherRecordingsAndLearnsTheSame) {
  PassContext ctx;
  DrivenPlaces places = places_driven_twice(2, kSmall);
  const ErrorModel model = value_of(of_ranges(train_model(ctx, quick(), places)));
  places.places[1].recordings.cards[0].digest[31] ^= 1;
  ErrorModel other = value_of(of_ranges(train_model(ctx, quick(), places)));
  EXPECT_NE(to_bytes(other), to_bytes(model));
  other.card.places[1].recordings.cards[0].digest[31] ^= 1;
  EXPECT_EQ(to_bytes(other), to_bytes(model));
  places.places[1].recordings.cards.clear();
  EXPECT_EQ(train_model(ctx, quick(), places).error().code, ErrorCode::kInvalidArtifact);
}

TEST(TrainModel, RefusesInputsOfDifferentMaps) {
  SyntheticDrive drive = synthetic_drive(1, kSmall);
  drive.sites.sites.pop_back();
  EXPECT_EQ(train(drive).error().code, ErrorCode::kMismatchedInputs);
  drive = synthetic_drive(1, kSmall);
  drive.factors.looks[1].range_m = 25.0;
  EXPECT_EQ(train(drive).error().code, ErrorCode::kMismatchedInputs);
  TrainModelOptions paper = quick();
  paper.features = FeatureSet::kPaper;
  EXPECT_EQ(train(synthetic_drive(1, kSmall), paper).error().code, ErrorCode::kMismatchedInputs);
}

}  // namespace
}  // namespace sightline
