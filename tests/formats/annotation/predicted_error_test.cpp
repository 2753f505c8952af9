#include "formats/annotation/predicted_error.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/artifact_checks.h"

namespace sightline {
namespace {

PredictedError two_sites() {
  PredictedError predicted;
  predicted.looks = every_return_at({10.0, 15.0});
  predicted.limits_m = {0.1, 0.25};
  predicted.site_count = 2;
  predicted.mean_m = {0.3, 0.2, 0.1, 0.05};
  predicted.within_probability = {0.0, 0.1, 0.25, 0.5, 0.5, 0.75, 0.9, 1.0};
  predicted.extrapolated = {0, 0, 0, 1};
  predicted.out_of_fold = {1, 0};
  predicted.has_history = {0, 1};
  return predicted;
}

ErrorCode code_of(const PredictedError& predicted) {
  const Result<void> valid = validate(predicted);
  return valid ? ErrorCode{} : valid.error().code;
}

TEST(PredictedError, SurvivesTheDisk) { expect_survives_disk(two_sites()); }

TEST(PredictedError, IsPrintedPerSiteAndRange) {
  const Table table = dump(two_sites());
  EXPECT_EQ(table.columns, (std::vector<std::string>{"site", "range_m", "look", "extrapolated",
                                                     "out_of_fold", "has_history", "mean_error_m",
                                                     "p_within_0.1_m", "p_within_0.25_m"}));
  ASSERT_EQ(table.rows.size(), 4u);
  EXPECT_EQ(table.rows[3],
            (std::vector<Cell>{std::int64_t{1}, 15.0, std::string("15 m"), std::int64_t{1},
                               std::int64_t{0}, std::int64_t{1}, 0.05, 0.9, 1.0}));
}

TEST(PredictedError, RefusesWhatCannotBePredicted) {
  PredictedError negative = two_sites();
  negative.mean_m[1] = -0.1;
  EXPECT_EQ(code_of(negative), ErrorCode::kInvalidArtifact);
  PredictedError certain = two_sites();
  certain.within_probability[7] = 1.5;
  EXPECT_EQ(code_of(certain), ErrorCode::kInvalidArtifact);
  PredictedError none = two_sites();
  none.within_probability[7] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(code_of(none), ErrorCode::kInvalidArtifact);
}

TEST(PredictedError, RefusesALooserLimitThatIsLessProbable) {
  PredictedError predicted = two_sites();
  predicted.within_probability[1] = 0.0;
  predicted.within_probability[0] = 0.1;
  EXPECT_EQ(code_of(predicted), ErrorCode::kInvalidArtifact);
}

TEST(PredictedError, RefusesListsThatDoNotFit) {
  PredictedError short_flags = two_sites();
  short_flags.extrapolated.pop_back();
  EXPECT_EQ(code_of(short_flags), ErrorCode::kInvalidArtifact);
  PredictedError descending = two_sites();
  std::swap(descending.looks[0].range_m, descending.looks[1].range_m);
  EXPECT_EQ(code_of(descending), ErrorCode::kInvalidArtifact);
  PredictedError more_sites = two_sites();
  more_sites.site_count = 3;
  EXPECT_EQ(code_of(more_sites), ErrorCode::kInvalidArtifact);
}

}  // namespace
}  // namespace sightline
