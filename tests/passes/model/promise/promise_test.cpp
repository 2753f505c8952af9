#include <gtest/gtest.h>

#include "passes/model/choose_ranges.h"
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
  EXPECT_NE(of_this.statement.find("on this drive at most 5 % of its sites"), std::string::npos);
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
      statement.ends_with(" of the sites missed 0.1 m (cross-validated on 10 blocks of 1 "
                          "place, 1 drive, with a threshold fitted to them)"))
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

}  // namespace
}  // namespace sightline
