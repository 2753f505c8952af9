#include <gtest/gtest.h>

#include "passes/model/choose_ranges.h"
#include "passes/model/promise/selection.h"
#include "tests/passes/model/honest_model.h"

// What is promised of the next drive, and what a map says where nothing is.

namespace sightline {
namespace {

TEST(Promise, PromisesTheNextDriveOnlyFromDrivesThatTheTreesDidNotLearnFrom) {
  ErrorModel model = honest_model(1, 60);
  const LimitPromise of_next = choose(model, with(RiskControl::kConformal))->promises[0];
  EXPECT_TRUE(of_next.is_earned);
  EXPECT_EQ(of_next.scope, PromiseScope::kNextDrive);
  model.card.hold_out = "blocks";
  for (const RiskControl risk_control : {RiskControl::kConformal, RiskControl::kLearnThenTest}) {
    const Result<RangeTable> table = choose(model, with(risk_control, 0.2));
    ASSERT_TRUE(table.has_value() && validate(*table).has_value());
    EXPECT_FALSE(table->promises[0].is_earned);
    EXPECT_EQ(table->promises[0].scope, PromiseScope::kThisDrive);
    EXPECT_NE(table->promises[0].statement.find("No promise for the next drive"), std::string::npos)
        << table->promises[0].statement;
  }
  const LimitPromise of_this = choose(model, with(RiskControl::kConformal))->promises[0];
  EXPECT_EQ(of_this.probability_threshold, of_next.probability_threshold) << "as careful as before";
  EXPECT_NE(of_this.statement.find("on this drive at most 5 % of its answered sites"),
            std::string::npos);
}

TEST(Promise, OneDriveAloneSaysOfThisDrive) {
  ErrorModel model = honest_model(1, 60);
  for (TrainedSite& site : model.sites) site.drive = 0;
  const LimitPromise promise = choose(model, with(RiskControl::kConformal))->promises[0];
  EXPECT_FALSE(promise.is_earned);
  EXPECT_EQ(promise.drive_count, 1u);
  EXPECT_NE(promise.statement.find("only one drive was measured; on this drive"), std::string::npos)
      << promise.statement;
}

TEST(Promise, NamesTheRouteThatIsNeededAndTheRouteThatThereIs) {
  ErrorModel model = honest_model(1, 10);
  for (TrainedSite& site : model.sites) site.drive = 0;
  const std::string statement = choose(model, with(RiskControl::kConformal))->promises[0].statement;
  EXPECT_TRUE(statement.starts_with(
      "No promise yet: it needs 1.2 km of route measured by two or more drives that the model was "
      "not trained on; so far there are 0.6 km from one drive; "))
      << statement;
  EXPECT_TRUE(
      statement.ends_with(" of the sites had no answer (cross-validated on 10 blocks of 1 place, 1 "
                          "drive, with a threshold fitted to them)"))
      << statement;
}

TEST(Promise, TheDriveThatMadeTheMapIsNoNextDrive) {
  ErrorModel model = honest_model(1, 60);
  std::vector<RecordingCard>& cards = model.card.places[0].recordings.cards;
  cards.erase(cards.begin() + 1);  // the first drive is half the scans of the mapping drive
  const LimitPromise split = choose(model, with(RiskControl::kConformal))->promises[0];
  EXPECT_FALSE(split.is_earned);
  EXPECT_EQ(split.scope, PromiseScope::kThisDrive);
  model = honest_model(1, 60);
  model.card.places[0].recordings.cards[1].digest = sha256("by foot");
  EXPECT_FALSE(choose(model, with(RiskControl::kConformal))->promises[0].is_earned)
      << "the same recording under another name";
}

TEST(Promise, CountsPlacesAndDrivesAndSaysWhereTheyAreFew) {
  ErrorModel model = honest_model(1, 60);
  const LimitPromise few = choose(model, with(RiskControl::kConformal))->promises[0];
  EXPECT_EQ(few.block_count, 60u);
  EXPECT_EQ(few.place_count, 1u);
  EXPECT_EQ(few.drive_count, 2u);
  EXPECT_NE(few.statement.find("60 blocks of 1 place, 2 drives"), std::string::npos);
  EXPECT_NE(few.statement.find("slightly optimistic: 5.1 to 5.9 %"), std::string::npos);
  const PlaceCard first = model.card.places[0];
  for (std::uint32_t place = 1; place < 4; ++place) {
    model.card.places.push_back(first);
    for (RecordingCard& card : model.card.places[place].recordings.cards) {
      card.digest = sha256(card.name + std::to_string(place));
    }
  }
  for (TrainedSite& site : model.sites) site.place = site.block / 15;
  const LimitPromise many = choose(model, with(RiskControl::kConformal))->promises[0];
  EXPECT_EQ(many.place_count, 4u);
  EXPECT_EQ(many.drive_count, 8u);
  EXPECT_NE(many.statement.find("60 blocks of 4 places, 8 drives"), std::string::npos);
  EXPECT_NE(many.statement.find("in the worst place"), std::string::npos) << many.statement;
  EXPECT_EQ(many.statement.find("optimistic"), std::string::npos) << many.statement;
}

// A tenth of the route is hopeless, and predicted so.
ErrorModel with_a_tunnel(std::size_t block_count) {
  ErrorModel model = honest_model(1, block_count);
  const std::size_t range_count = model.ranges.size();
  for (std::size_t site = 0; site < model.sites.size(); ++site) {
    if (model.sites[site].block % 10 != 0) continue;
    for (std::size_t range = 0; range < range_count; ++range) {
      const std::size_t i = site * range_count + range;
      model.measured_mean_m[i] = 0.9;
      model.out_of_fold.mean_m[i] = 0.9;
      model.out_of_fold.within_probability[2 * i] = 0.1;
      model.out_of_fold.within_probability[2 * i + 1] = 0.2;
    }
  }
  return model;
}

TEST(Promise, OfGeneratedWorldsIsNoPromiseForRecordedDrives) {
  ErrorModel model = honest_model(1, 60);
  const Result<RangeTable> recorded = choose(model, with(RiskControl::kConformal));
  ASSERT_TRUE(recorded->promises[0].is_earned);
  model.card.worlds = "generated";
  const Result<RangeTable> generated = choose(model, with(RiskControl::kConformal));
  ASSERT_TRUE(generated.has_value() && validate(*generated).has_value());
  const LimitPromise& promise = generated->promises[0];
  EXPECT_FALSE(promise.is_earned);
  EXPECT_TRUE(promise.statement.starts_with(
      "Predicted from generated worlds: no promise for recorded drives ("))
      << promise.statement;
  EXPECT_TRUE(
      promise.statement.ends_with("Over generated worlds: " + recorded->promises[0].statement))
      << promise.statement;
  EXPECT_EQ(generated->range_index, recorded->range_index) << "answers stay as they are";
}

TEST(Promise, IsAboutTheAnsweredSitesAndStatesTheOthers) {
  const RangeTable table = value_of(choose(with_a_tunnel(60), with(RiskControl::kConformal)));
  const RangeTable without = value_of(choose(honest_model(1, 60), with(RiskControl::kConformal)));
  const LimitPromise& promise = table.promises[0];
  EXPECT_TRUE(promise.is_earned) << promise.statement;
  EXPECT_NEAR(promise.probability_threshold, without.promises[0].probability_threshold, 0.03)
      << "the tunnel asks nothing of the rest";
  EXPECT_NEAR(promise.answered_share, 0.9 * without.promises[0].answered_share, 0.03);
  EXPECT_LE(promise.calibration_miss_share, 0.05);
  for (std::size_t site = 0; site < 60; ++site) {
    EXPECT_NE(table.flags_of(site, 0) & kUnmet, 0) << "site " << site << " of the tunnel";
  }
  EXPECT_NE(promise.statement.find("at most 5 % of this place's answered sites"),
            std::string::npos);
  EXPECT_NE(promise.statement.find(" of the sites had no answer"), std::string::npos);
  EXPECT_NE(promise.statement.find("60 blocks allow 3."), std::string::npos) << promise.statement;
}

// The cap was part of the calibration.
TEST(Promise, IsKeptWhereTheModelsAnswerForATighterLimitIsTakenOver) {
  ErrorModel model = with_a_tunnel(60);
  const std::size_t range_count = model.ranges.size();
  for (std::size_t i = 0; i < model.measured_mean_m.size(); ++i) {
    if (model.sites[i / range_count].block % 10 != 0) continue;
    model.measured_mean_m[i] = model.out_of_fold.mean_m[i] = 0.2;
    if (i % range_count >= 2) model.out_of_fold.within_probability[2 * i + 1] = 0.99;
  }
  const RangeTable table = value_of(choose(model, with(RiskControl::kConformal)));
  EXPECT_EQ(table.reason(0, 1), Reason::kTighterLimit);
  EXPECT_TRUE(table.promises[1].is_earned) << table.promises[1].statement;
}

TEST(Promise, OfAStricterAlphaIsAboutSitesThatALooserOneAnswersToo) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    for (const std::size_t block_count : {8u, 24u, 60u}) {
      const ErrorModel model = honest_model(seed, block_count);
      for (const RiskControl risk_control :
           {RiskControl::kConformal, RiskControl::kLearnThenTest, RiskControl::kEmpirical}) {
        std::vector<std::uint8_t> was_answered(model.sites.size(), 0);
        for (const double alpha : {0.01, 0.02, 0.05, 0.1, 0.2, 0.5}) {
          const RangeTable table = value_of(choose(model, with(risk_control, alpha)));
          for (std::size_t site = 0; site < was_answered.size(); ++site) {
            const bool is_answered = (table.flags_of(site, 0) & kUnmet) == 0;
            EXPECT_GE(is_answered, was_answered[site] == 1) << "site " << site << ", " << alpha;
            was_answered[site] = is_answered ? 1 : 0;
          }
        }
      }
    }
  }
}

TEST(Promise, NoAlphaAnswersBelowTheLeastProbability) {
  const ErrorModel model = honest_model(2, 60);
  for (const double alpha : {0.05, 0.5}) {
    const RangeTable table = value_of(choose(model, with(RiskControl::kConformal, alpha)));
    for (std::size_t site = 0; site < table.site_count; ++site) {
      double most = 0.0;
      for (std::size_t range = 0; range < model.ranges.size(); ++range) {
        most = std::max(most, model.out_of_fold.probability(site, range, 0));
      }
      EXPECT_TRUE(most >= kLeastProbability || (table.flags_of(site, 0) & kUnmet) != 0);
    }
  }
}

TEST(Promise, CountsABlockOnceHoweverManyPlacesOfTheTrainingShareIt) {
  ErrorModel model = honest_model(1, 60);
  model.card.places.push_back(model.card.places[0]);
  for (TrainedSite& site : model.sites) site.p_world_m = {site.s_m, 0.0, 0.0};
  const std::size_t half = model.sites.size() / 2;
  for (std::size_t i = half; i < model.sites.size(); ++i) {
    model.sites[i].place = 1;  // of the same recordings, in the next lane
    model.sites[i].p_world_m = model.sites[i - half].p_world_m + Eigen::Vector3d(0.0, 3.5, 0.0);
  }
  EXPECT_EQ(choose(model, with(RiskControl::kConformal))->promises[0].block_count, 30u);
  for (std::size_t i = half; i < model.sites.size(); ++i) model.sites[i].p_world_m.y() = 40.0;
  EXPECT_EQ(choose(model, with(RiskControl::kConformal))->promises[0].block_count, 30u)
      << "one street in other axes";
  for (TrainedSite& site : model.sites) site.p_world_m.x() += 588000.0;
  EXPECT_EQ(choose(model, with(RiskControl::kConformal))->promises[0].block_count, 60u)
      << "another road of the world";
}

}  // namespace
}  // namespace sightline
