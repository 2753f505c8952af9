#include "passes/model/choice/left_out.h"

#include <gtest/gtest.h>

#include "passes/model/add_history.h"
#include "passes/model/forest/measured_columns.h"
#include "passes/model/forest/predict_error.h"
#include "passes/model/train_model.h"
#include "tests/support/synthetic_places.h"

namespace sightline {
namespace {

const SyntheticOptions kSmall = {
    .site_count = 120, .ranges_m = {10.0, 20.0, 30.0}, .has_paper_factors = false};

// Two places driven four times.
const ErrorModel& model() {
  static const ErrorModel kModel = [] {
    DrivenPlaces places;
    for (const std::uint64_t seed : {1, 2}) {
      places.places.push_back(place_driven_often(seed, 4, kSmall));
    }
    TrainModelOptions options;
    options.trees = 20;
    PassContext ctx;
    Result<ErrorModel> trained = train_model(ctx, options, places);
    EXPECT_TRUE(trained.has_value()) << to_string(trained.error());
    return std::move(*trained);
  }();
  return kModel;
}

// Another place, its drives and what they are called.
struct Street {
  DrivenPlace place = place_driven_often(9, 4, kSmall);
  MeasuredDrives measured_here{{place.drives[0], place.drives[2], place.drives[3]}, {0, 2, 3}, 4};

  Street() {
    for (Site& site : place.sites.sites) site.p_map_m.y() += 1000.0;
  }
};

FactorTable factors_of(const Street& street) {
  PassContext ctx;
  const Result<PredictedError> predicted =
      predict_error(ctx, {}, model(), street.place.sites, street.place.factors,
                    street.place.recordings, nullptr, &street.measured_here);
  EXPECT_TRUE(predicted.has_value());
  const Result<FactorTable> factors =
      add_history(ctx, {}, street.place.factors, street.measured_here, *predicted, model(),
                  street.place.recordings);
  EXPECT_TRUE(factors.has_value());
  return *factors;
}

std::vector<LeftOutDrive> left_out_of(const Street& street, const FactorTable& factors) {
  PassContext ctx;
  const Result<std::vector<LeftOutDrive>> left_out =
      leave_out_in_turn(ctx, model(), street.place.sites, factors, 0.25);
  EXPECT_TRUE(left_out.has_value());
  return *left_out;
}

TEST(LeftOut, EachDriveIsForetoldByTheOthersAlone) {
  const Street street;
  const std::vector<LeftOutDrive> left_out = left_out_of(street, factors_of(street));
  ASSERT_EQ(left_out.size(), 3U) << "n drives are n cases";
  for (std::size_t i = 0; i < 3; ++i) {
    MeasuredDrives others = street.measured_here;
    others.drives.erase(others.drives.begin() + static_cast<std::ptrdiff_t>(i));
    PassContext ctx;
    const Result<PredictedError> expected = predict_error(
        ctx, {}, model(), street.place.sites, street.place.factors, {}, nullptr, &others);
    EXPECT_EQ(to_bytes(left_out[i].predicted), to_bytes(*expected));
    EXPECT_EQ(left_out[i].measured.row(7, 1).mean_m,
              street.measured_here.drives[i].row(7, 1).mean_m);
  }
}

// History and label are never of one drive: what a drive found moves no prediction that it judges.
TEST(LeftOut, NothingThatADriveFoundReachesItsOwnPrediction) {
  const Street street;
  const std::vector<LeftOutDrive> before = left_out_of(street, factors_of(street));
  for (std::size_t i = 0; i < 3; ++i) {
    Street other = street;
    for (ErrorRow& row : other.measured_here.drives[i].rows) row.mean_m = row.p90_m = 3.0;
    const std::vector<LeftOutDrive> after = left_out_of(other, factors_of(other));
    for (std::size_t k = 0; k < 3; ++k) {
      const bool is_same = to_bytes(after[k].predicted) == to_bytes(before[k].predicted);
      EXPECT_EQ(is_same, k == i) << "drive " << i << " as drive " << k << " is judged";
    }
  }
}

TEST(LeftOut, OfDrivesThatMadeTheMapOrTheModelNoneJudges) {
  Street street;
  street.place.recordings.cards[0].digest = street.place.recordings.cards[1].digest;  // the map's
  EXPECT_EQ(left_out_of(street, factors_of(street)).size(), 2U);
  Street known;
  for (RecordingCard& card : known.place.recordings.cards) {
    if (card.role == "localization[3]") {
      card.digest = model().card.places[0].recordings.cards[1].digest;
    }
  }
  EXPECT_EQ(left_out_of(known, factors_of(known)).size(), 2U);
  // Listed twice under two names, a drive would predict itself.
  Street twice;
  RecordingCard* first = nullptr;
  for (RecordingCard& card : twice.place.recordings.cards) {
    if (card.role == "localization[3]") first = &card;
    if (card.role == "localization[4]") card.digest = first->digest;
  }
  EXPECT_EQ(left_out_of(twice, factors_of(twice)).size(), 1U);
}

TEST(LeftOut, OneDriveIsNotHeard) {
  Street street;
  street.measured_here = {{street.place.drives[0]}, {0}, 1};
  EXPECT_TRUE(left_out_of(street, factors_of(street)).empty());
  EXPECT_TRUE(left_out_of(street, street.place.factors).empty()) << "nor where none is known";
}

}  // namespace
}  // namespace sightline
