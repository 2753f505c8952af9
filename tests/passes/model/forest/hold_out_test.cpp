#include "passes/model/forest/hold_out.h"

#include <gtest/gtest.h>

#include "formats/model/error_model.h"
#include "tests/support/synthetic_places.h"

namespace sightline {
namespace {

const SyntheticOptions kTiny = {.site_count = 5, .ranges_m = {10.0}, .has_paper_factors = false};

RecordingCards cards_of(const std::vector<std::string>& recordings) {
  RecordingCards cards;
  for (const std::string& recording : recordings) {
    const std::string role = cards.cards.empty() ? "mapping" : "localization";
    cards.cards.push_back({role, recording, sha256(recording)});
  }
  return cards;
}

std::vector<std::uint32_t> groups(const std::vector<RecordingCards>& places) {
  std::vector<const RecordingCards*> pointers;
  for (const RecordingCards& place : places) pointers.push_back(&place);
  return groups_by_recording(pointers);
}

TEST(HoldOut, TakesPlacesThatShareARecordingForOne) {
  const std::vector<RecordingCards> places = {cards_of({"a", "b"}), cards_of({"c", "d"}),
                                              cards_of({"e", "a"}), cards_of({"f", "g"})};
  EXPECT_EQ(groups(places), (std::vector<std::uint32_t>{0, 1, 0, 2}));
}

TEST(HoldOut, JoinsPlacesByWayOfOthers) {
  const std::vector<RecordingCards> places = {cards_of({"a", "b"}), cards_of({"c", "d"}),
                                              cards_of({"e", "f"}), cards_of({"d", "b"})};
  EXPECT_EQ(groups(places), (std::vector<std::uint32_t>{0, 0, 1, 0}));
}

TEST(HoldOut, KnowsADriveByItsRecordingWhateverItsName) {
  DrivenPlaces places = places_driven_twice(2, kTiny);
  EXPECT_EQ(learnt_drives(places).count, 4u);
  EXPECT_EQ(learnt_drives(places).independent_count, 4u);
  places.places[1].recordings.cards[2].digest = places.places[0].recordings.cards[1].digest;
  const LearntDrives drives = learnt_drives(places);
  EXPECT_EQ(drives.count, 3u);
  EXPECT_EQ(drives.number[1][1], drives.number[0][0]);
}

TEST(HoldOut, KnowsThatHalfTheScansOfADriveAreThatDrive) {
  DrivenPlaces places = places_driven_twice(1, kTiny);
  RecordingCards& recordings = places.places[0].recordings;
  recordings.cards.erase(recordings.cards.begin() + 1);
  EXPECT_EQ(learnt_drives(places).count, 2u);
  EXPECT_EQ(learnt_drives(places).independent_count, 1u);
  EXPECT_TRUE(made_the_map(recordings, recordings_of_drives(recordings, 2)[0]));
  EXPECT_FALSE(made_the_map(recordings, recordings_of_drives(recordings, 2)[1]));
}

TEST(HoldOut, SaysNothingOfDrivesWithoutCards) {
  DrivenPlaces places = places_driven_twice(1, kTiny);
  places.places[0].drives.pop_back();
  EXPECT_TRUE(recordings_of_drives(places.places[0].recordings, 1).empty());
  EXPECT_EQ(learnt_drives(places).count, 1u);
  EXPECT_EQ(learnt_drives(places).independent_count, 0u);
}

}  // namespace
}  // namespace sightline
