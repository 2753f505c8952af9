#include "passes/model/forest/folds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "formats/base/random.h"
#include "formats/model/error_model.h"
#include "tests/support/synthetic_places.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

Sites straight_route(std::size_t count) {
  Sites sites;
  for (std::size_t i = 0; i < count; ++i) {
    Site site;
    site.s_m = static_cast<double>(i);
    site.p_map_m.x() = static_cast<double>(i);
    sites.sites.push_back(site);
  }
  return sites;
}

std::vector<std::uint8_t> all_labelled(std::size_t count) {
  return std::vector<std::uint8_t>(count, 1);
}

struct CutRoute {
  std::vector<TrainedSite> sites;
  Folds folds;
};

CutRoute cut(std::size_t count, std::uint32_t fold_count) {
  const RouteBlocks blocks = *cut_route(straight_route(count), all_labelled(count), 60.0, 2);
  CutRoute route;
  for (std::size_t i = 0; i < count; ++i) {
    TrainedSite site;
    site.p_world_m.x() = site.s_m = static_cast<double>(i);
    site.block = blocks.block_of_site[i];
    route.sites.push_back(site);
  }
  for (std::uint32_t block = 0; block < blocks.block_count; ++block) {
    route.folds.fold_of_block.push_back(block);
  }
  deal_blocks(fold_count, route.folds);
  return route;
}

TEST(Folds, CutTheRouteIntoAsManyBlocksAsFit) {
  const RouteBlocks blocks = value_of(cut_route(straight_route(200), all_labelled(200), 60.0, 2));
  EXPECT_EQ(blocks.block_count, 3u);
  EXPECT_EQ(blocks.labelled_route_m, 200.0);
  EXPECT_EQ(blocks.block_of_site[66], 0u);
  EXPECT_EQ(blocks.block_of_site[67], 1u);
  EXPECT_EQ(blocks.block_of_site[199], 2u);
}

TEST(Folds, GiveEachBlockItsLengthOfLabelledRoute) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    Random random(seed);
    const std::size_t count = 150 + random.below(400);
    std::vector<std::uint8_t> has_label(count);
    for (std::uint8_t& label : has_label) label = random.uniform() < 0.9 ? 1 : 0;
    const RouteBlocks blocks = value_of(cut_route(straight_route(count), has_label, 60.0, 2));
    EXPECT_TRUE(std::is_sorted(blocks.block_of_site.begin(), blocks.block_of_site.end()));
    std::map<std::uint32_t, int> labelled_in_block;
    for (std::size_t i = 0; i < count; ++i) {
      labelled_in_block[blocks.block_of_site[i]] += has_label[i];
    }
    ASSERT_EQ(labelled_in_block.size(), blocks.block_count);
    for (const auto& [block, labelled] : labelled_in_block) EXPECT_GE(labelled, 60);
  }
}

TEST(Folds, DealBlocksInTurnAndKeepTogetherWhatHasOneNumber) {
  Folds folds;
  folds.fold_of_block = {0, 0, 1, 2, 2, 3};
  deal_blocks(3, folds);
  EXPECT_EQ(folds.fold_count, 3u);
  EXPECT_EQ(folds.fold_of_block, (std::vector<std::uint32_t>{0, 0, 1, 2, 2, 0}));
  deal_blocks(10, folds);
  EXPECT_EQ(folds.fold_count, 3u);
}

TEST(Folds, LeaveNothingWithinTheBufferOfAFold) {
  const CutRoute route = cut(400, 3);
  for (std::uint32_t fold = 0; fold < route.folds.fold_count; ++fold) {
    const std::vector<std::uint8_t> is_near = sites_near_fold(route.sites, route.folds, fold, 25.0);
    for (std::size_t i = 0; i < 400; ++i) {
      double nearest_m = 1e9;
      for (std::size_t j = 0; j < 400; ++j) {
        if (route.folds.fold_of_block[route.sites[j].block] != fold) continue;
        nearest_m =
            std::min(nearest_m, (route.sites[i].p_world_m - route.sites[j].p_world_m).norm());
      }
      EXPECT_EQ(is_near[i] != 0, nearest_m <= 25.0) << "site " << i << ", fold " << fold;
    }
  }
}

TEST(Folds, DoNotLeakWhereTheRouteCrossesItself) {
  CutRoute route = cut(240, 4);
  // The second half drives the first half again, 2 m to the side.
  for (std::size_t i = 120; i < 240; ++i) {
    route.sites[i].p_world_m = Eigen::Vector3d(static_cast<double>(i - 120), 2.0, 0.0);
  }
  const std::vector<std::uint8_t> is_near = sites_near_fold(route.sites, route.folds, 0, 25.0);
  EXPECT_EQ(is_near[150], 1);  // beside site 30, which is in fold 0
  EXPECT_EQ(is_near[230], 0);
}

TEST(Folds, KnowThatAnotherPlaceIsElsewhereWhateverItsCoordinates) {
  CutRoute route = cut(240, 4);
  for (std::size_t i = 120; i < 240; ++i) {
    route.sites[i].p_world_m = route.sites[i - 120].p_world_m;
    route.sites[i].place = 1;
  }
  EXPECT_EQ(sites_near_fold(route.sites, route.folds, 0, 25.0)[150], 0);
}

TEST(Folds, RefuseADriveTooShortAndSayWhatIsNeeded) {
  const Error refused = failure_of(cut_route(straight_route(119), all_labelled(119), 60.0, 2));
  EXPECT_EQ(refused.code, ErrorCode::kDriveTooShort);
  EXPECT_NE(refused.message.find("119 m"), std::string::npos);
  EXPECT_NE(refused.message.find("120 m"), std::string::npos);
  EXPECT_EQ(value_of(cut_route(straight_route(30), all_labelled(30), 60.0, 1)).block_count, 1u);
}

TEST(Folds, RefuseARouteWithoutLabels) {
  EXPECT_EQ(
      failure_of(cut_route(straight_route(200), std::vector<std::uint8_t>(200, 0), 60.0, 2)).code,
      ErrorCode::kNoTrainingRows);
}

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
  const std::vector<std::uint32_t> numbers = origins_by_recording({&recordings}).recordings[0];
  EXPECT_TRUE(made_the_map(recordings, numbers, recordings_of_drives(recordings, 2)[0]));
  EXPECT_FALSE(made_the_map(recordings, numbers, recordings_of_drives(recordings, 2)[1]));
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
