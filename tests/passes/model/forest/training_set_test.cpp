#include "passes/model/forest/training_set.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "passes/model/forest/history.h"
#include "tests/support/synthetic_places.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

const SyntheticOptions kSmall = {
    .site_count = 130, .ranges_m = {10.0, 20.0}, .has_paper_factors = false};

TEST(TrainingSet, TakesTheLabelFromAnotherDriveThanTheHistory) {
  const DrivenPlaces places = places_driven_twice(1, kSmall);
  const TrainingSet training_set = value_of(make_training_set({}, places));
  ASSERT_EQ(training_set.sites.size(), 4u * 130u);
  const std::size_t width = training_set.features.names.size();
  const DrivenPlace& place = places.places[0];
  // Cases: drive 0 alone, 0 knowing 1, 1 alone, 1 knowing 0.
  const std::size_t label_drive[] = {0, 0, 1, 1};
  const std::size_t history_drive[] = {9, 1, 9, 0};
  const std::size_t own_log = width - history_features().size();  // history_log_mean
  for (std::size_t c = 0; c < 4; ++c) {
    for (std::size_t i = 0; i < 130; ++i) {
      const std::size_t site = c * 130 + i;
      EXPECT_EQ(training_set.labels[site * 2], place.drives[label_drive[c]].row(i, 0).mean_m);
      EXPECT_EQ(training_set.sites[site].has_history, c % 2);
      const float own_feature = training_set.features.row(site * 2)[own_log];
      const double expected =
          c % 2 == 0 ? 0.0 : std::log(place.drives[history_drive[c]].row(i, 0).mean_m);
      EXPECT_EQ(own_feature, static_cast<float>(expected));
    }
  }
}

// Cases grow with the drives, not with their pairs; every number of earlier drives is among them.
TEST(TrainingSet, TellsEachDriveWhatOthersFoundAndNeverItself) {
  for (const std::size_t drive_count : {std::size_t{3}, std::size_t{7}}) {
    DrivenPlaces places;
    places.places.push_back(place_driven_often(1, drive_count, kSmall));
    const TrainingSet training_set = value_of(make_training_set({}, places));
    EXPECT_EQ(training_set.history_kind, HistoryKind::kOfSeveral);
    ASSERT_EQ(training_set.sites.size(), 2 * drive_count * 130);
    const std::vector<std::string>& names = training_set.features.names;
    const auto column = [&](const char* name) {
      return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
    };
    std::set<int> told_counts;
    for (std::size_t c = 0; c < 2 * drive_count; ++c) {
      const std::size_t label = c / 2;
      const std::size_t site = c * 130 + 17;
      EXPECT_EQ(training_set.labels[site * 2], places.places[0].drives[label].row(17, 0).mean_m);
      EXPECT_EQ(training_set.sites[site].drive, label);
      EXPECT_EQ(training_set.sites[site].has_history, c % 2);
      const float* row = training_set.features.row(site * 2);
      const auto told_count = static_cast<std::size_t>(row[column("history_drives")]);
      if (c % 2 == 0) {
        EXPECT_EQ(told_count, 0u);
        continue;
      }
      told_counts.insert(static_cast<int>(told_count));
      // Those behind the label's drive in a circle, and so never itself.
      double sum = 0.0;
      for (std::size_t i = 1; i <= told_count; ++i) {
        sum += std::log(places.places[0].drives[(label + i) % drive_count].row(17, 0).mean_m);
      }
      EXPECT_LT(told_count, drive_count);
      EXPECT_NEAR(row[column("history_log_mean")], sum / static_cast<double>(told_count), 1e-5);
    }
    EXPECT_EQ(told_counts.size(), drive_count - 1);
  }
}

TEST(TrainingSet, HoldsOutTheSameStretchInEveryCase) {
  const TrainingSet training_set = value_of(make_training_set({}, places_driven_twice(2, kSmall)));
  EXPECT_EQ(training_set.folds.block_count(), 4u);
  std::set<std::uint32_t> runs;
  for (std::size_t i = 0; i < training_set.sites.size(); ++i) {
    const TrainedSite& site = training_set.sites[i];
    runs.insert(site.run);
    EXPECT_EQ(site.block, training_set.sites[i / (4 * 130) * 4 * 130 + i % 130].block);
  }
  EXPECT_EQ(runs.size(), 8u);  // no case runs into the next
}

TEST(TrainingSet, RefusesDrivesOfDifferentLocalizers) {
  DrivenPlaces places = places_driven_twice(2, kSmall);
  places.places[1].drives[1].matching.localizer = {"pcl-ndt", 3, {{"voxel_m", "3"}}};
  const Error refused = failure_of(make_training_set({}, places));
  EXPECT_EQ(refused.code, ErrorCode::kMismatchedInputs);
  EXPECT_EQ(refused.place, "place place 2");
  EXPECT_NE(refused.message.find("'again' was localized by pcl-ndt v3 (voxel_m=3)"),
            std::string::npos)
      << refused.message;
}

// A localizer that takes its time is measured at every tenth site: the route is as long all the
// same.
TEST(TrainingSet, CountsTheRouteThatAMeasuredSiteStandsFor) {
  DrivenPlaces places = places_driven_twice(1, kSmall);
  places.places[0].drives.pop_back();
  MeasuredError& drive = places.places[0].drives[0];
  for (std::size_t i = 0; i < drive.scan_of_site.size(); ++i) {
    if (i % 10 == 5) continue;
    drive.scan_of_site[i] = -1;
    for (std::size_t range = 0; range < 2; ++range) drive.rows[2 * i + range] = ErrorRow{};
  }
  EXPECT_EQ(make_training_set({}, places).error().code, ErrorCode::kDriveTooShort);
  drive.matching.site_step = 10;
  const TrainingSet training_set = value_of(make_training_set({}, places));
  EXPECT_EQ(training_set.folds.labelled_route_m, 130.0);
  EXPECT_EQ(labelled_rows(training_set, std::vector<std::uint8_t>(130, 0), 100000).rows.size(),
            13u * 2u)
      << "it learns from what was measured alone";
}

TEST(TrainingSet, HoldsOutWholePlacesWhereThereAreTwo) {
  const TrainingSet three = value_of(make_training_set({}, places_driven_twice(3, kSmall)));
  EXPECT_EQ(three.held_out, HoldOut::kPlaces);
  EXPECT_EQ(three.folds.fold_count, 3u);
  for (const TrainedSite& site : three.sites) {
    EXPECT_EQ(three.folds.fold_of_block[site.block], site.place);
  }
  EXPECT_EQ(make_training_set({}, places_driven_twice(2, kSmall))->held_out, HoldOut::kPlaces);
  const TrainingSetOptions blocks{.hold_out = HoldOut::kBlocks};
  EXPECT_EQ(make_training_set(blocks, places_driven_twice(3, kSmall))->held_out, HoldOut::kBlocks);
}

TEST(TrainingSet, HoldsPlacesOfOneRecordingOutTogether) {
  DrivenPlaces places = places_driven_twice(3, kSmall);
  places.places[2].recordings.cards[0].digest = places.places[0].recordings.cards[1].digest;
  const TrainingSet training_set = value_of(make_training_set({}, places));
  EXPECT_EQ(training_set.folds.fold_count, 2u);
  for (const TrainedSite& site : training_set.sites) {
    EXPECT_EQ(training_set.folds.fold_of_block[site.block], site.place % 2);
  }
}

TEST(TrainingSet, HoldsOutDrivesWhereOnePlaceWasDrivenTwice) {
  const DrivenPlaces twice = places_driven_twice(1, kSmall);
  EXPECT_EQ(make_training_set({}, twice)->held_out, HoldOut::kDrives);
  DrivenPlaces once = twice;
  once.places[0].drives.pop_back();
  once.places[0].recordings.cards.pop_back();
  EXPECT_EQ(make_training_set({}, once)->held_out, HoldOut::kBlocks);
  DrivenPlaces split = twice;  // half its scans made the map, the other half are the first drive
  split.places[0].recordings.cards.erase(split.places[0].recordings.cards.begin() + 1);
  EXPECT_EQ(make_training_set({}, split)->held_out, HoldOut::kBlocks);
  const TrainingSetOptions drives{.hold_out = HoldOut::kDrives};
  EXPECT_EQ(failure_of(make_training_set(drives, once)).code, ErrorCode::kNoTrainingRows);
}

TEST(TrainingSet, KnowsNoHistoryWherePlacesWereDrivenOnce) {
  DrivenPlaces places = places_driven_twice(2, kSmall);
  for (DrivenPlace& place : places.places) place.drives.pop_back();
  const TrainingSet training_set = value_of(make_training_set({}, places));
  EXPECT_FALSE(training_set.knows_history);
  for (const std::string& name : training_set.features.names)
    EXPECT_FALSE(is_history_feature(name));
}

TEST(TrainingSet, ThinsByWholeSites) {
  const TrainingSet training_set = value_of(make_training_set({}, places_driven_twice(1, kSmall)));
  const std::vector<std::uint8_t> none(training_set.sites.size(), 0);
  EXPECT_EQ(labelled_rows(training_set, none, 100000).rows.size(), 4u * 130u * 2u);
  const LabelledRows thin = labelled_rows(training_set, none, 300);
  EXPECT_LE(thin.rows.size(), 300u);
  EXPECT_GE(thin.rows.size(), 200u);
  for (std::size_t i = 0; i < thin.rows.size(); i += 2) {
    EXPECT_EQ(thin.rows[i] % 2, 0u);
    EXPECT_EQ(thin.rows[i + 1], thin.rows[i] + 1);
  }
}

TEST(TrainingSet, NamesThePlaceOfANumberThatIsNone) {
  DrivenPlaces places = places_driven_twice(2, kSmall);
  places.places[1].drives[0].rows[5].mean_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(failure_of(make_training_set({}, places)).code, ErrorCode::kInvalidArtifact);
}

}  // namespace
}  // namespace sightline
