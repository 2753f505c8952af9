#include "passes/model/forest/lesson.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "passes/model/forest/history.h"
#include "tests/support/synthetic_places.h"

namespace sightline {
namespace {

const SyntheticOptions kSmall = {
    .site_count = 130, .ranges_m = {10.0, 20.0}, .has_paper_factors = false};

TEST(Lesson, TakesTheLabelFromAnotherDriveThanTheHistory) {
  const DrivenPlaces places = places_driven_twice(1, kSmall);
  const Result<Lesson> lesson = make_lesson({}, places);
  ASSERT_TRUE(lesson.has_value()) << to_string(lesson.error());
  ASSERT_EQ(lesson->sites.size(), 4u * 130u);
  const std::size_t width = lesson->features.names.size();
  const DrivenPlace& place = places.places[0];
  // Cases: drive 0 alone, 0 told of 1, 1 alone, 1 told of 0.
  const std::size_t label_drive[] = {0, 0, 1, 1};
  const std::size_t history_drive[] = {9, 1, 9, 0};
  const std::size_t own_log = width - history_features().size();  // history_log_mean
  for (std::size_t c = 0; c < 4; ++c) {
    for (std::size_t i = 0; i < 130; ++i) {
      const std::size_t site = c * 130 + i;
      EXPECT_EQ(lesson->labels[site * 2], place.drives[label_drive[c]].row(i, 0).mean_m);
      EXPECT_EQ(lesson->sites[site].has_history, c % 2);
      const float told = lesson->features.row(site * 2)[own_log];
      const double expected =
          c % 2 == 0 ? 0.0 : std::log(place.drives[history_drive[c]].row(i, 0).mean_m);
      EXPECT_EQ(told, static_cast<float>(expected));
    }
  }
}

TEST(Lesson, HoldsOutTheSameStretchInEveryCase) {
  const Result<Lesson> lesson = make_lesson({}, places_driven_twice(2, kSmall));
  ASSERT_TRUE(lesson.has_value());
  EXPECT_EQ(lesson->folds.block_count(), 4u);
  std::set<std::uint32_t> runs;
  for (std::size_t i = 0; i < lesson->sites.size(); ++i) {
    const TrainedSite& site = lesson->sites[i];
    runs.insert(site.run);
    EXPECT_EQ(site.block, lesson->sites[i / (4 * 130) * 4 * 130 + i % 130].block);
  }
  EXPECT_EQ(runs.size(), 8u);  // no case runs into the next
}

TEST(Lesson, HoldsOutWholePlacesWhereThereAreThree) {
  const Result<Lesson> three = make_lesson({}, places_driven_twice(3, kSmall));
  ASSERT_TRUE(three.has_value());
  EXPECT_TRUE(three->holds_out_places);
  EXPECT_EQ(three->folds.fold_count, 3u);
  for (const TrainedSite& site : three->sites) {
    EXPECT_EQ(three->folds.fold_of_block[site.block], site.place);
  }
  EXPECT_FALSE(make_lesson({}, places_driven_twice(2, kSmall))->holds_out_places);
  LessonOptions blocks;
  blocks.hold_out = HoldOut::kBlocks;
  EXPECT_FALSE(make_lesson(blocks, places_driven_twice(3, kSmall))->holds_out_places);
}

TEST(Lesson, KnowsNoHistoryWherePlacesWereDrivenOnce) {
  DrivenPlaces places = places_driven_twice(2, kSmall);
  for (DrivenPlace& place : places.places) place.drives.pop_back();
  const Result<Lesson> lesson = make_lesson({}, places);
  ASSERT_TRUE(lesson.has_value());
  EXPECT_FALSE(lesson->knows_history);
  for (const std::string& name : lesson->features.names) EXPECT_FALSE(is_history_feature(name));
}

TEST(Lesson, ThinsByWholeSites) {
  const Result<Lesson> lesson = make_lesson({}, places_driven_twice(1, kSmall));
  ASSERT_TRUE(lesson.has_value());
  const std::vector<std::uint8_t> none(lesson->sites.size(), 0);
  EXPECT_EQ(labelled_rows(*lesson, none, 100000).rows.size(), 4u * 130u * 2u);
  const LabelledRows thin = labelled_rows(*lesson, none, 300);
  EXPECT_LE(thin.rows.size(), 300u);
  EXPECT_GE(thin.rows.size(), 200u);
  for (std::size_t i = 0; i < thin.rows.size(); i += 2) {
    EXPECT_EQ(thin.rows[i] % 2, 0u);
    EXPECT_EQ(thin.rows[i + 1], thin.rows[i] + 1);
  }
}

TEST(Lesson, NamesThePlaceOfANumberThatIsNone) {
  DrivenPlaces places = places_driven_twice(2, kSmall);
  places.places[1].drives[0].rows[5].mean_m = std::numeric_limits<double>::quiet_NaN();
  const Result<Lesson> lesson = make_lesson({}, places);
  ASSERT_FALSE(lesson.has_value());
  EXPECT_EQ(lesson.error().code, ErrorCode::kInvalidArtifact);
}

}  // namespace
}  // namespace sightline
