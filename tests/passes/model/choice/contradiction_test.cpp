#include "passes/model/choice/contradiction.h"

#include <gtest/gtest.h>

#include "passes/model/promise/promise_text.h"
#include "tests/passes/model/honest_model.h"

namespace sightline {
namespace {

TEST(BinomialTail, IsThatOfTablesAndOfEveryCount) {
  EXPECT_DOUBLE_EQ(binomial_tail(10, 0, 0.05), 1.0);
  EXPECT_NEAR(binomial_tail(10, 1, 0.05), 1.0 - 0.5987369392383787, 1e-12);
  EXPECT_NEAR(binomial_tail(10, 4, 0.05), 0.0010284976, 1e-9);
  EXPECT_NEAR(binomial_tail(3, 2, 0.5), 0.5, 1e-12);
  EXPECT_EQ(binomial_tail(3, 4, 0.5), 0.0);
  for (std::uint32_t least = 1; least <= 2000; least += 7) {
    EXPECT_LE(binomial_tail(2000, least + 1, 0.05), binomial_tail(2000, least, 0.05) + 1e-12);
  }
}

// Errors of one drive at the sites of a model: what its own labels are, or more.
MeasuredError measured_as(const ErrorModel& model, double share_missing) {
  MeasuredError measured;
  measured.drive = "here";
  measured.matching.localizer = model.card.localizer;
  measured.looks = model.out_of_fold.looks;
  Random chance(7);
  for (std::size_t site = 0; site < model.sites.size(); ++site) {
    measured.scan_of_site.push_back(0);
    const bool is_missed = chance.uniform() < share_missing;
    for (std::size_t range = 0; range < model.ranges.size(); ++range) {
      ErrorRow row;
      row.mean_m = is_missed ? 0.5 : model.measured(site, range);
      measured.rows.push_back(row);
    }
  }
  return measured;
}

LimitPromise promise_beside(const ErrorModel& model, const MeasuredError* measured) {
  const ByFamily<MeasuredError> both(measured == nullptr ? MeasuredError{} : *measured);
  return of_ranges(choose_ranges(TestContext(), with(RiskControl::kConformal), sites_of(model),
                                 model.out_of_fold, model, demanding_factors(model),
                                 measured == nullptr ? nullptr : &both))
      ->promises[0];
}

TEST(Contradiction, WithdrawsAPromiseThatTheMapsOwnErrorsContradict) {
  const ErrorModel model = honest_model(1, 60);
  ASSERT_TRUE(promise_beside(model, nullptr).is_earned);
  const MeasuredError bad = measured_as(model, 0.5);
  const LimitPromise withdrawn = promise_beside(model, &bad);
  EXPECT_FALSE(withdrawn.is_earned);
  EXPECT_TRUE(is_contradicted(withdrawn)) << withdrawn.statement;
  EXPECT_NE(withdrawn.statement.find("the model's promise was 95 %"), std::string::npos)
      << withdrawn.statement;
}

TEST(Contradiction, KeepsThePromisesOfHonestModels) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const ErrorModel model = honest_model(seed, 60);
    const MeasuredError honest = measured_as(model, 0.0);
    EXPECT_EQ(promise_beside(model, &honest).is_earned, promise_beside(model, nullptr).is_earned)
        << "seed " << seed;
  }
}

TEST(Contradiction, IsNoneOfSimulatedErrorsOrOfAnotherLocalizer) {
  const ErrorModel model = honest_model(1, 60);
  MeasuredError simulated = measured_as(model, 0.5);
  simulated.reference = ErrorReference::kSimulated;
  EXPECT_TRUE(promise_beside(model, &simulated).is_earned);
  MeasuredError other = measured_as(model, 0.5);
  other.matching.localizer.name = "other";
  EXPECT_TRUE(promise_beside(model, &other).is_earned);
}

// Misses at all sites of one of ten blocks are what one block in twenty may well do.
TEST(Contradiction, CountsBlocksAndNotTheirSites) {
  Sites sites;
  MeasuredError measured;
  measured.looks = {every_return(10.0)};
  Choice choice = choose_everywhere(0, 600);
  for (int i = 0; i < 600; ++i) {
    Site site;
    site.s_m = i;
    sites.sites.push_back(site);
    measured.scan_of_site.push_back(i);
    ErrorRow row;
    row.mean_m = i < 60 ? 0.5 : 0.05;
    measured.rows.push_back(row);
  }
  EXPECT_FALSE(contradiction_of(sites, measured, choice, 0.1, 0.05));
  for (int i = 60; i < 240; ++i) measured.rows[static_cast<std::size_t>(i)].mean_m = 0.5;
  const std::optional<Contradiction> found = contradiction_of(sites, measured, choice, 0.1, 0.05);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->block_count, 9U) << "of 599 m";
  EXPECT_EQ(found->missed_blocks, 3U);
  EXPECT_NEAR(found->share_within, 0.6, 1e-12);
  for (std::uint8_t& flags : choice.flags) flags |= kUnmet;
  EXPECT_FALSE(contradiction_of(sites, measured, choice, 0.1, 0.05)) << "nothing was answered";
}

}  // namespace
}  // namespace sightline
