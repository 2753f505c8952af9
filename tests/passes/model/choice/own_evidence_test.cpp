#include "passes/model/choice/own_evidence.h"

#include <gtest/gtest.h>

#include "passes/model/choose_ranges.h"
#include "passes/model/forest/predict_error.h"
#include "passes/model/train_model.h"
#include "tests/support/handmade_model.h"
#include "tests/support/synthetic_places.h"
#include "tests/support/test_context.h"
#include "tests/support/whole_rows.h"

namespace sightline {
namespace {

// 20 m of street: its own scans are within 0.1 m from 20 m on; a range of 10 m serves half of them.
struct ShortDrive {
  SyntheticDrive drive = synthetic_drive(
      1, {.site_count = 20, .ranges_m = {10.0, 20.0, 30.0}, .has_paper_factors = false});
  std::vector<std::string> warnings;
  PassContext ctx;

  ShortDrive() {
    std::vector<std::vector<double>> own_error_m;
    for (int i = 0; i < 20; ++i) own_error_m.push_back({i < 10 ? 0.05 : 0.3, 0.06, 0.04});
    drive.factors = factors_with_own_error(ranges_of(drive.factors.looks), own_error_m);
    ctx.warning_sink = [this](const std::string& message) { warnings.push_back(message); };
    ctx.information_sink = ctx.warning_sink;
  }
  Result<ErrorModel> trained() {
    return of_ranges(train_model_here(ctx, {}, drive.sites, drive.factors, drive.measured,
                                      synthetic_recordings(0)));
  }
};

TEST(OwnEvidenceModel, EveryShortDriveGetsItsOwnStaticAnswerFlaggedAndWithoutAPromise) {
  ShortDrive street;
  const ErrorModel model = value_of(street.trained());
  ASSERT_TRUE(validate(model).has_value()) << to_string(validate(model).error());
  ASSERT_EQ(street.warnings.size(), 1u);
  EXPECT_NE(street.warnings[0].find("too little data to train on"), std::string::npos);
  const SyntheticDrive& drive = street.drive;
  const PredictedError predicted = value_of(of_ranges(
      predict_error(street.ctx, {}, model, drive.sites, drive.factors, synthetic_recordings(0))));
  EXPECT_NEAR(predicted.probability(3, 0, 0), 0.5, 1e-12) << "share of its own scans at 10 m";
  EXPECT_NEAR(predicted.mean(3, 0), 0.175, 1e-12);
  EXPECT_EQ(predicted.probability(3, 1, 0), 1.0);
  const RangeTable table = value_of(
      of_ranges(choose_ranges(street.ctx, {}, drive.sites, predicted, model, drive.factors)));
  for (std::size_t site = 0; site < 20; ++site) {
    EXPECT_EQ(table.range_m(site, 0), 20.0);
    EXPECT_EQ(table.flags_of(site, 0), kStatic);
    EXPECT_EQ(table.reason(site, 0), Reason::kTooShort);
  }
  EXPECT_FALSE(table.promises[0].is_earned);
  EXPECT_NE(table.promises[0].statement.find("No promise: the drive is too short"),
            std::string::npos)
      << table.promises[0].statement;
}

TEST(OwnEvidenceModel, TellsLooksApartThatReachEquallyFar) {
  ShortDrive street;
  FactorTable& factors = street.drive.factors;
  factors.looks = {{.range_m = 100.0, .return_count = 400, .point_count = 32},
                   {.range_m = 100.0, .return_count = 650, .point_count = 40},
                   {.range_m = 100.0, .return_count = 1000, .point_count = 64}};
  street.drive.measured.looks = factors.looks;
  FactorTable with_number = factors;
  with_number.factors.emplace_back("look_number");
  with_number.values.clear();
  for (std::size_t site = 0; site < 20; ++site) {
    for (std::size_t look = 0; look < 3; ++look) {
      for (std::size_t f = 0; f < factors.factors.size(); ++f) {
        with_number.values.push_back(factors.at(site, look, f));
      }
      with_number.values.push_back(static_cast<double>(look));
    }
  }
  factors = with_number;
  const ErrorModel model = value_of(street.trained());
  ASSERT_TRUE(validate(model).has_value()) << to_string(validate(model).error());
  const PredictedError predicted = value_of(of_ranges(
      predict_error(street.ctx, {}, model, street.drive.sites, factors, synthetic_recordings(0))));
  EXPECT_NEAR(predicted.probability(3, 0, 0), 0.5, 1e-12) << "half of its scans, not all";
  EXPECT_NEAR(predicted.mean(3, 0), 0.175, 1e-12);
  EXPECT_NEAR(predicted.mean(3, 1), 0.06, 1e-12);
  EXPECT_NEAR(predicted.mean(3, 2), 0.04, 1e-12);
}

TEST(OwnEvidenceModel, AlsoWhereNoScanLiesNearASite) {
  ShortDrive street;
  std::ranges::fill(street.drive.measured.scan_of_site, -1);
  std::ranges::fill(street.drive.measured.rows, ErrorRow{});
  EXPECT_TRUE(street.trained().has_value());
}

TEST(OwnEvidenceModel, SurvivesTheDisk) {
  ShortDrive street;
  const ErrorModel model = value_of(street.trained());
  EXPECT_EQ(to_bytes(value_of(from_bytes<ErrorModel>(to_bytes(model)))), to_bytes(model));
}

TEST(OwnEvidenceModel, OfOneRangeHasATreeOfOneLeaf) {
  SyntheticDrive drive =
      synthetic_drive(1, {.site_count = 2, .ranges_m = {10.0}, .has_paper_factors = false});
  drive.factors = factors_with_own_error({10.0}, {{0.05}, {0.2}});
  const ErrorModel model = value_of(model_of_own_evidence(
      drive.sites, drive.factors, drive.measured, synthetic_recordings(0), {0.1}));
  ASSERT_TRUE(validate(model).has_value());
  EXPECT_NEAR(model.out_of_fold.probability(0, 0, 0), 0.5, 1e-12);
}

TEST(OwnEvidenceModel, RefusesFactorsThatTellNothingOfTheMapsOwnScans) {
  const SyntheticDrive drive =
      synthetic_drive(1, {.site_count = 5, .ranges_m = {10.0}, .has_paper_factors = false});
  EXPECT_EQ(model_of_own_evidence(drive.sites, drive.factors, drive.measured,
                                  synthetic_recordings(0), {0.1})
                .error()
                .code,
            ErrorCode::kMismatchedInputs);
}

TEST(TrainModel, NamesThePlaceThatIsTooShort) {
  DrivenPlaces places = places_driven_twice(
      1, {.site_count = 20, .ranges_m = {10.0, 20.0}, .has_paper_factors = false});
  places.places[0].name = "market/street.yaml";
  const Error refused = failure_of(train_model(TestContext(), {}, places));
  EXPECT_EQ(refused.code, ErrorCode::kDriveTooShort);
  EXPECT_NE(to_string(refused).find("market/street.yaml"), std::string::npos) << to_string(refused);
}

}  // namespace
}  // namespace sightline
