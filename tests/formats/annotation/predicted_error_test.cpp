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
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  expect_refused<PredictedError>(
      two_sites(), {[](PredictedError& negative) { negative.mean_m[1] = -0.1; },
                    [](PredictedError& certain) { certain.within_probability[7] = 1.5; },
                    [](PredictedError& none) { none.within_probability[7] = kNan; },
                    [](PredictedError& looser_is_less_probable) {
                      looser_is_less_probable.within_probability[1] = 0.0;
                      looser_is_less_probable.within_probability[0] = 0.1;
                    },
                    [](PredictedError& short_flags) { short_flags.extrapolated.pop_back(); },
                    [](PredictedError& descending) {
                      std::swap(descending.looks[0].range_m, descending.looks[1].range_m);
                    },
                    [](PredictedError& more_sites) { more_sites.site_count = 3; }});
}

}  // namespace
}  // namespace sightline
