#include "passes/weakness/weak_cause.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/passes/weakness/corridor.h"

namespace sightline {
namespace {

UprightSights plenty() {
  UprightSights sights;
  sights.count = 100;
  sights.holding_count = 10;
  sights.nearest_holding_m = 12.0;
  sights.one_sidedness = 0.5;
  return sights;
}

TEST(WeakCause, TakesTheFirstThatHolds) {
  EXPECT_EQ(cause_of(plenty(), 0.3, 50.0), WeakCause::kUnclear);
  EXPECT_EQ(cause_of(plenty(), 0.95, 50.0), WeakCause::kRepeated);
  EXPECT_EQ(cause_of(plenty(), std::nullopt, 50.0), WeakCause::kUnclear);
  UprightSights far = plenty();
  far.nearest_holding_m = 26.0;
  EXPECT_EQ(cause_of(far, 0.3, 50.0), WeakCause::kDistant);
  far.nearest_holding_m.reset();
  EXPECT_EQ(cause_of(far, 0.3, 50.0), WeakCause::kDistant);
  far.one_sidedness = 0.99;
  EXPECT_EQ(cause_of(far, 0.95, 50.0), WeakCause::kOneSided);
  far.count = 3;
  EXPECT_EQ(cause_of(far, 0.95, 50.0), WeakCause::kEmpty);
}

TEST(WeakCause, HasAWordForEach) {
  std::set<std::string_view> words;
  for (int cause = 0; cause < 5; ++cause) words.insert(name_of(static_cast<WeakCause>(cause)));
  EXPECT_EQ(words.size(), 5U);
}

TEST(UprightSights, OfACorridorFaceOneWay) {
  const CorridorScene scene;
  const UprightSights sights = upright_sights(scene.views.front(), scene.nds, 0.0);
  EXPECT_GT(sights.count, 50U);
  EXPECT_EQ(sights.holding_count, 0U);
  EXPECT_FALSE(sights.nearest_holding_m);
  EXPECT_GT(sights.one_sidedness, 0.99);
  // Across the street every one holds; the walls are 8.1 m away.
  const UprightSights across = upright_sights(scene.views.front(), scene.nds, 90.0);
  EXPECT_EQ(across.holding_count, across.count);
  EXPECT_NEAR(*across.nearest_holding_m, 8.2, 0.6);
}

TEST(UprightSights, SeeTheWallThatEndsTheStreet) {
  const CorridorScene scene(true);
  const UprightSights sights = upright_sights(scene.views.front(), scene.nds, 0.0);
  EXPECT_GT(sights.holding_count, 5U);
  EXPECT_NEAR(*sights.nearest_holding_m, 38.1, 0.6);  // from x = 40
}

}  // namespace
}  // namespace sightline
