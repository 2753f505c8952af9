#include "passes/model/choice/leave_one_drive_out.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "formats/base/random.h"
#include "passes/model/add_history.h"
#include "passes/model/choice/choices.h"
#include "passes/model/forest/measured_columns.h"
#include "passes/model/forest/predict_error.h"
#include "passes/model/promise/promise_text.h"
#include "passes/model/train_model.h"
#include "tests/support/handmade_model.h"
#include "tests/support/synthetic_places.h"
#include "tests/support/test_context.h"
#include "tests/support/whole_rows.h"

namespace sightline {
namespace {

// A street of sites 1 m apart, by looks of which each costs as much as its number, from 1 on.
struct Street {
  std::vector<LeftOutDrive> left_out;
  OwnEvidence evidence;
};

// P(error <= 0.1 m) of each site and look; and, drive by drive, what was measured there.
Street street_of(const std::vector<std::vector<double>>& probability,
                 const std::vector<std::vector<std::vector<double>>>& error_m) {
  Street street;
  const std::size_t look_count = probability.front().size();
  for (std::size_t look = 0; look < look_count; ++look) {
    street.evidence.looks.push_back(every_return(10.0 * static_cast<double>(look + 1)));
  }
  street.evidence.site_count = static_cast<std::uint32_t>(probability.size());
  for (std::size_t site = 0; site < probability.size(); ++site) {
    for (std::size_t look = 0; look < look_count; ++look) {
      street.evidence.error_m.push_back(0.0);
      street.evidence.cost.push_back(static_cast<double>(look + 1));
    }
  }
  for (const std::vector<std::vector<double>>& of_drive : error_m) {
    LeftOutDrive drive;
    drive.predicted.looks = drive.measured.looks = street.evidence.looks;
    drive.predicted.limits_m = {0.1};
    drive.predicted.site_count = street.evidence.site_count;
    drive.predicted.has_history.assign(probability.size(), 1);
    drive.measured.scan_of_site.assign(probability.size(), 0);
    for (std::size_t site = 0; site < probability.size(); ++site) {
      for (std::size_t look = 0; look < look_count; ++look) {
        drive.predicted.within_probability.push_back(probability[site][look]);
        drive.measured.rows.emplace_back().mean_m = of_drive[site][look];
      }
    }
    street.left_out.push_back(std::move(drive));
  }
  return street;
}

Choice rule_at(const PredictedError& predicted, double threshold) {
  return choose_by_probability(predicted, 0, {threshold, threshold});
}

DriveVote vote_of(const Street& street, const DriveVoteOptions& options) {
  const std::optional<DriveVote> answer =
      leave_one_drive_out(street.left_out, street.evidence, options, rule_at);
  EXPECT_TRUE(answer.has_value());
  return answer.value_or(DriveVote{});
}

// The second of two sites is hard, and the model knows it.
Street hard_and_easy() {
  return street_of({{0.9, 0.95}, {0.3, 0.95}},
                   {{{0.05, 0.05}, {0.2, 0.05}}, {{0.05, 0.05}, {0.2, 0.05}}});
}

TEST(LeaveOneDriveOut, TakeTheLeastThresholdThatCovers) {
  const DriveVote answer = vote_of(hard_and_easy(), {.coverage = 0.99});
  EXPECT_FALSE(answer.everywhere.has_value());
  EXPECT_EQ(answer.threshold, kLeastProbability) << "there the hard site takes the dearer look";
  EXPECT_EQ(answer.standing.coverage, 1.0);
  EXPECT_EQ(answer.standing.cost, 1.5);
  EXPECT_EQ(answer.case_count, 4U);
  EXPECT_EQ(answer.drive_count, 2U);
  EXPECT_EQ(
      drives_text(answer.drive_count, answer.standing.coverage, 0.1),
      "; cross-validated over the 2 drives here, 100.0 % of the answered sites are within 0.1 m");
  EXPECT_NEAR(vote_of(hard_and_easy(), {.coverage = 0.5}).standing.cost, 1.0, 1e-12);
}

TEST(LeaveOneDriveOut, TakeOneAnswerEverywhereWhereTheModelIsDearerForNothing) {
  const Street street = street_of({{0.1, 0.95}, {0.1, 0.95}},
                                  {{{0.05, 0.05}, {0.05, 0.05}}, {{0.05, 0.05}, {0.05, 0.05}}});
  DriveVoteOptions options{.coverage = 0.99, .is_promised = true, .threshold = 0.75, .alpha = 0.05};
  options.block_count = 5.0;
  EXPECT_TRUE(vote_of(street, options).keeps_promise) << "five blocks prove nothing";
  EXPECT_EQ(vote_of(street, options).threshold, 0.75);
  options.block_count = 30.0;
  EXPECT_FALSE(vote_of(street, options).keeps_promise);
  EXPECT_EQ(vote_of(street, options).standing.cost, 1.0);
}

TEST(LeaveOneDriveOut, AskForMoreThanThePromiseWhereTheStreetIsHarder) {
  const DriveVote answer =
      vote_of(hard_and_easy(), {.coverage = 0.99, .is_promised = true, .threshold = 0.2});
  EXPECT_TRUE(answer.keeps_promise);
  EXPECT_EQ(answer.threshold, kLeastProbability);
  EXPECT_EQ(
      vote_of(hard_and_easy(), {.coverage = 0.99, .is_promised = true, .threshold = 0.9}).threshold,
      0.9)
      << "never less strict than what was promised";
}

// The second of three sites is hopeless, the third looks better than it is.
TEST(LeaveOneDriveOut, CountMissesAmongTheAnsweredSitesAlone) {
  const std::vector<std::vector<double>> error_m = {{0.05, 0.05}, {0.9, 0.9}, {0.3, 0.3}};
  const Street street = street_of({{0.9, 0.95}, {0.1, 0.2}, {0.7, 0.75}}, {error_m, error_m});
  const DriveVote answer = vote_of(street, {.coverage = 0.99});
  EXPECT_FALSE(answer.everywhere.has_value());
  EXPECT_NEAR(answer.threshold, 0.755, 1e-12);
  EXPECT_EQ(answer.standing.coverage, 1.0);
}

TEST(LeaveOneDriveOut, CountOnlyWhatOthersDroveBy) {
  Street street = hard_and_easy();
  street.left_out[0].measured.scan_of_site[1] = -1;
  street.left_out[1].predicted.has_history[0] = 0;
  EXPECT_EQ(vote_of(street, {}).case_count, 2U);
  for (LeftOutDrive& drive : street.left_out) drive.predicted.has_history = {0, 0};
  EXPECT_FALSE(leave_one_drive_out(street.left_out, street.evidence, {}, rule_at).has_value());
}

// Honest predictions: a site with P misses with probability 1 - P, on every drive anew.
Street honest_street(Random& random, std::size_t drive_count) {
  std::vector<std::vector<double>> probability;
  for (int site = 0; site < 200; ++site) {
    std::vector<double> of_site;
    for (int look = 0; look < 4; ++look) {
      of_site.push_back(std::clamp(random.uniform(0.4, 0.8) + 0.15 * look, 0.0, 1.0));
    }
    probability.push_back(of_site);
  }
  std::vector<std::vector<std::vector<double>>> error_m(drive_count);
  for (std::vector<std::vector<double>>& of_drive : error_m) {
    for (const std::vector<double>& of_site : probability) {
      std::vector<double>& errors = of_drive.emplace_back();
      for (const double p : of_site) errors.push_back(random.uniform() < p ? 0.05 : 0.3);
    }
  }
  return street_of(probability, error_m);
}

TEST(LeaveOneDriveOut, ALooserCoverageNeverCostsMoreAndWhatCanBeCoveredIs) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    Random random(seed);
    const Street street = honest_street(random, 3);
    double dearest = 0.0;
    for (const double coverage : {0.6, 0.7, 0.8, 0.9, 0.95}) {
      const DriveVote answer = vote_of(street, {.coverage = coverage});
      EXPECT_GE(answer.standing.coverage, coverage) << seed;
      EXPECT_GE(answer.standing.cost, dearest) << seed;
      dearest = answer.standing.cost;
    }
  }
}

TEST(LeaveOneDriveOut, ForetellTheNextDrive) {
  double within = 0.0;
  double count = 0.0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    Random random(seed);
    Street street = honest_street(random, 7);
    const LeftOutDrive next = street.left_out.back();
    street.left_out.pop_back();
    const DriveVote answer = vote_of(street, {.coverage = 0.9});
    const Choice choice = rule_at(next.predicted, answer.threshold);
    for (std::size_t site = 0; site < street.evidence.site_count; ++site) {
      const std::size_t look = answer.everywhere.value_or(choice.range_index[site]);
      within += next.measured.row(site, look).mean_m <= 0.1 ? 1.0 : 0.0;
      count += 1.0;
    }
  }
  EXPECT_GE(within / count, 0.895);
}

// Drives were within 10 m everywhere, where the model only believes in 20 m.
TEST(LeaveOneDriveOut, IsTheReasonWhereOneAnswerIsTakenEverywhere) {
  ErrorModel model =
      handmade_model(std::vector<HandmadeSite>(20, {{0.001, 0.95}, {0.05, 0.04}}), 4);
  model.out_of_fold.has_history.assign(20, 1);
  for (std::size_t i = 0; i < 20; i += 2) model.sites[i].has_history = 1;
  const OwnEvidence evidence = *own_evidence_of(
      factors_with_own_error({10, 20}, std::vector<std::vector<double>>(20, {0.05, 0.04})));
  MeasuredError measured;
  measured.looks = model.out_of_fold.looks;
  measured.scan_of_site.assign(20, 0);
  measured.rows.resize(40);
  const std::vector<LeftOutDrive> left_out(2, {model.out_of_fold, measured});
  const Sites sites = sites_of(model);
  ChooseRangesOptions options{.risk_control = RiskControl::kEmpirical};
  options.alpha = 0.05;
  const Chosen chosen = choose_all(options, {sites, model.out_of_fold, model, evidence, left_out});
  EXPECT_EQ(chosen.choices[0].range_index, std::vector<std::uint8_t>(20, 0));
  EXPECT_EQ(chosen.choices[0].reasons, std::vector<Reason>(20, Reason::kDrives));
}

const SyntheticOptions kSmall = {
    .site_count = 120, .ranges_m = {10.0, 20.0, 30.0}, .has_paper_factors = false};

const ErrorModel& model() {
  static const ErrorModel kModel = [] {
    DrivenPlaces places;
    for (const std::uint64_t seed : {1, 2}) {
      places.places.push_back(place_driven_often(seed, 4, kSmall));
    }
    const TrainModelOptions options{.trees = 20};
    Result<ErrorModel> trained = of_ranges(train_model(TestContext(), options, places));
    EXPECT_TRUE(trained.has_value()) << to_string(trained.error());
    return std::move(*trained);
  }();
  return kModel;
}

struct DrivenStreet {
  DrivenPlace place = place_driven_often(9, 4, kSmall);
  MeasuredDrives measured_here{{place.drives[0], place.drives[2], place.drives[3]}, {0, 2, 3}, 4};

  DrivenStreet() {
    for (Site& site : place.sites.sites) site.p_map_m.y() += 1000.0;
  }
};

FactorTable factors_of(const DrivenStreet& street) {
  PassContext ctx;
  const Result<PredictedError> predicted =
      of_ranges(predict_error(ctx, {}, model(), street.place.sites, street.place.factors,
                              street.place.recordings, nullptr, &street.measured_here));
  EXPECT_TRUE(predicted.has_value());
  const Result<FactorTable> factors =
      of_ranges(add_history(ctx, {}, street.place.factors, street.measured_here, *predicted,
                            model(), street.place.recordings));
  EXPECT_TRUE(factors.has_value());
  return *factors;
}

std::vector<LeftOutDrive> left_out_of(const DrivenStreet& street, const FactorTable& factors) {
  const Result<std::vector<LeftOutDrive>> left_out =
      leave_out_in_turn(TestContext(), model(), street.place.sites, factors, 0.25);
  EXPECT_TRUE(left_out.has_value());
  return *left_out;
}

TEST(LeftOut, EachDriveIsForetoldByTheOthersAlone) {
  const DrivenStreet street;
  const std::vector<LeftOutDrive> left_out = left_out_of(street, factors_of(street));
  ASSERT_EQ(left_out.size(), 3U) << "n drives are n cases";
  for (std::size_t i = 0; i < 3; ++i) {
    MeasuredDrives others = street.measured_here;
    others.drives.erase(others.drives.begin() + static_cast<std::ptrdiff_t>(i));
    PassContext ctx;
    const Result<PredictedError> expected = of_ranges(predict_error(
        ctx, {}, model(), street.place.sites, street.place.factors, {}, nullptr, &others));
    EXPECT_EQ(to_bytes(left_out[i].predicted), to_bytes(*expected));
    EXPECT_EQ(left_out[i].measured.row(7, 1).mean_m,
              street.measured_here.drives[i].ranges.row(7, 1).mean_m);
  }
}

TEST(LeftOut, NothingThatADriveFoundReachesItsOwnPrediction) {
  const DrivenStreet street;
  const std::vector<LeftOutDrive> before = left_out_of(street, factors_of(street));
  for (std::size_t i = 0; i < 3; ++i) {
    DrivenStreet other = street;
    for (ErrorRow& row : other.measured_here.drives[i].ranges.rows) row.mean_m = row.p90_m = 3.0;
    const std::vector<LeftOutDrive> after = left_out_of(other, factors_of(other));
    for (std::size_t k = 0; k < 3; ++k) {
      const bool is_same = to_bytes(after[k].predicted) == to_bytes(before[k].predicted);
      EXPECT_EQ(is_same, k == i) << "drive " << i << " as drive " << k << " is judged";
    }
  }
}

TEST(LeftOut, OfDrivesThatMadeTheMapOrTheModelNoneJudges) {
  DrivenStreet street;
  street.place.recordings.cards[0].digest = street.place.recordings.cards[1].digest;  // the map's
  EXPECT_EQ(left_out_of(street, factors_of(street)).size(), 2U);
  DrivenStreet known;
  for (RecordingCard& card : known.place.recordings.cards) {
    if (card.role == "localization[3]") {
      card.digest = model().card.places[0].recordings.cards[1].digest;
    }
  }
  EXPECT_EQ(left_out_of(known, factors_of(known)).size(), 2U);
  // Listed twice under two names, a drive would predict itself.
  DrivenStreet twice;
  RecordingCard* first = nullptr;
  for (RecordingCard& card : twice.place.recordings.cards) {
    if (card.role == "localization[3]") first = &card;
    if (card.role == "localization[4]") card.digest = first->digest;
  }
  EXPECT_EQ(left_out_of(twice, factors_of(twice)).size(), 1U);
}

TEST(LeftOut, OneDriveIsNotHeard) {
  DrivenStreet street;
  street.measured_here = {{street.place.drives[0]}, {0}, 1};
  EXPECT_TRUE(left_out_of(street, factors_of(street)).empty());
  EXPECT_TRUE(left_out_of(street, street.place.factors).empty()) << "nor where none is known";
}

}  // namespace
}  // namespace sightline
