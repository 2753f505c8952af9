#include "passes/emit/prove_annotation.h"

#include <gtest/gtest.h>

#include <functional>

#include "passes/model/add_history.h"
#include "passes/model/choose_ranges.h"
#include "passes/model/forest/measured_columns.h"
#include "passes/model/forest/predict_error.h"
#include "passes/model/train_model.h"
#include "tests/support/synthetic_places.h"
#include "tests/support/test_context.h"
#include "tests/support/whole_rows.h"

namespace sightline {
namespace {

const SyntheticOptions kSmall = {
    .site_count = 120, .ranges_m = {10.0, 20.0, 30.0}, .has_paper_factors = false};

const ErrorModel& model() {
  static const ErrorModel kModel = [] {
    const TrainModelOptions options{.trees = 20};
    Result<ErrorModel> trained =
        of_ranges(train_model(TestContext(), options, places_driven_twice(2, kSmall)));
    EXPECT_TRUE(trained.has_value()) << to_string(trained.error());
    return std::move(*trained);
  }();
  return kModel;
}

FactorTable with_own_error(const FactorTable& factors, const MeasuredError& measured) {
  FactorTable table = factors;
  table.factors.insert(table.factors.begin(), "own_error");
  table.values.clear();
  const std::size_t count = factors.factors.size();
  for (std::size_t row = 0; row < measured.rows.size(); ++row) {
    table.values.push_back(measured.rows[row].mean_m);
    const auto values = factors.values.begin() + static_cast<std::ptrdiff_t>(row * count);
    table.values.insert(table.values.end(), values, values + static_cast<std::ptrdiff_t>(count));
  }
  return table;
}

// Annotated as emit-map and the passes before it do; `has_history`: with what a first drive
// measured there.
CompiledMap annotated(const DrivenPlace& place, bool has_history) {
  PassContext ctx;
  CompiledMap map;
  map.sites = place.sites;
  const ByFamily<MeasuredError> first(place.drives[0]);
  map.factors =
      has_history ? of_ranges(with_measured_columns(place.factors, first)) : place.factors;
  map.factors = with_own_error(map.factors, place.drives[0]);
  const Result<PredictedError> predicted =
      of_ranges(predict_error(ctx, {}, model(), place.sites, place.factors, place.recordings,
                              has_history ? &first : nullptr));
  EXPECT_TRUE(predicted.has_value()) << to_string(predicted.error());
  map.predicted = *predicted;
  const Result<RangeTable> ranges =
      of_ranges(choose_ranges(ctx, {}, place.sites, *predicted, model(), map.factors));
  EXPECT_TRUE(ranges.has_value()) << to_string(ranges.error());
  map.ranges = *ranges;
  map.model = record_of(model());
  map.quality = quality_of(map.predicted, map.ranges, nullptr);
  return map;
}

DrivenPlace elsewhere() {
  DrivenPlace place = place_driven_twice(9, kSmall);
  for (Site& site : place.sites.sites) site.p_map_m.y() += 1000.0;
  return place;
}

Result<AnnotationProof> prove(const CompiledMap& map) {
  return prove_annotation(TestContext(), map);
}

ErrorCode code_of(const CompiledMap& map) {
  const Result<AnnotationProof> proof = prove(map);
  return proof ? ErrorCode{} : proof.error().code;
}

TEST(ProveAnnotation, MakesAnotherPlacesPredictionsAgainFromItsFactors) {
  const AnnotationProof proof = value_of(prove(annotated(elsewhere(), false)));
  EXPECT_EQ(proof.site_count, 120u);
  EXPECT_EQ(proof.forest_count, 120u);
  EXPECT_EQ(proof.history_count, 0u);
}

TEST(ProveAnnotation, MakesThemAgainWithWhatAnEarlierDriveMeasured) {
  const AnnotationProof proof = value_of(prove(annotated(elsewhere(), true)));
  EXPECT_EQ(proof.history_count, 120u);
}

TEST(ProveAnnotation, MakesThemAgainWithWhatSeveralDrivesMeasured) {
  DrivenPlace place = place_driven_often(9, 4, kSmall);
  for (Site& site : place.sites.sites) site.p_map_m.y() += 1000.0;
  const MeasuredDrives history{{place.drives[0], place.drives[1], place.drives[3]}, {0, 1, 3}, 4};
  PassContext ctx;
  CompiledMap map = annotated(place, false);
  const PredictedError predicted = value_of(of_ranges(predict_error(
      ctx, {}, model(), place.sites, place.factors, place.recordings, nullptr, &history)));
  map.predicted = predicted;
  const FactorTable factors = value_of(
      of_ranges(add_history(ctx, {}, map.factors, history, predicted, model(), place.recordings)));
  map.factors = factors;
  EXPECT_EQ(map.factors.factors.back(), "measured_is_independent[3]");
  map.ranges = *of_ranges(choose_ranges(ctx, {}, place.sites, predicted, model(), map.factors));
  map.quality = quality_of(map.predicted, map.ranges, nullptr);
  const AnnotationProof proof = value_of(prove(map));
  EXPECT_EQ(proof.history_count, 120u);
  map.factors.values.end()[-4] += 0.5;  // an error of the last drive
  EXPECT_EQ(code_of(map), ErrorCode::kDigestMismatch);
}

TEST(ProveAnnotation, SaysWhichSitesTheModelKeepsPredictionsOf) {
  const AnnotationProof proof = value_of(prove(annotated(place_driven_twice(1, kSmall), false)));
  EXPECT_EQ(proof.out_of_fold_count, 120u);
  EXPECT_NE(to_text(proof).find("120 sites trained the model"), std::string::npos);
}

TEST(ProveAnnotation, RefusesAnyStoredNumberThatDoesNotFollow) {
  const CompiledMap map = annotated(elsewhere(), true);
  const std::vector<std::function<void(CompiledMap&)>> flips = {
      [](CompiledMap& m) { m.predicted.mean_m[200] *= 1.0 + 1e-15; },
      [](CompiledMap& m) { m.predicted.within_probability[301] += 1e-12; },
      [](CompiledMap& m) { m.predicted.extrapolated[7] ^= 1; },
      [](CompiledMap& m) { m.predicted.out_of_fold[8] ^= 1; },
      [](CompiledMap& m) { m.predicted.has_history[9] ^= 1; },
      [](CompiledMap& m) {
        m.ranges.range_index[30] =
            m.ranges.range_index[30] == 0 ? std::uint8_t{1} : std::uint8_t{0};
      },
      [](CompiledMap& m) { m.ranges.flags[31] ^= kUnmet; },
      [](CompiledMap& m) { m.ranges.reasons[31] = Reason::kNone; },
      [](CompiledMap& m) { m.ranges.promises[0].is_earned ^= true; },
      [](CompiledMap& m) { m.ranges.promises[1].history_threshold += 0.005; },
      [](CompiledMap& m) { m.ranges.promises[0].answered_share *= 0.5; },
      [](CompiledMap& m) { m.ranges.promises[0].statement += " or so"; },
      [](CompiledMap& m) { ++m.quality[0].unmet_count; },
      [](CompiledMap& m) { m.model.localizer.name = "pcl-ndt"; },
      [](CompiledMap& m) { m.quality[1].expected_coverage = 1.0; },
      [](CompiledMap& m) { m.factors.values.end()[-3] += 0.5; },  // an error of the first drive
      [](CompiledMap& m) { m.factors.values[2] += 1000.0; }};     // beyond the support
  ASSERT_EQ(code_of(map), ErrorCode{});
  for (std::size_t i = 0; i < flips.size(); ++i) {
    CompiledMap flipped = map;
    flips[i](flipped);
    EXPECT_EQ(code_of(flipped), ErrorCode::kDigestMismatch) << "flip " << i;
  }
}

TEST(ProveAnnotation, NamesTheSiteAndWhatItFound) {
  CompiledMap map = annotated(elsewhere(), false);
  map.predicted.mean_m[3 * 41 + 1] = 0.5;
  const Error error = prove(map).error();
  EXPECT_EQ(error.place, "site 41");
  EXPECT_NE(error.message.find("found a predicted error of 0.5 m at 20 m"), std::string::npos)
      << error.message;
}

TEST(ProveAnnotation, RefusesAMapThatWasStripped) {
  CompiledMap no_factors = annotated(elsewhere(), false);
  no_factors.factors = {};
  EXPECT_EQ(code_of(no_factors), ErrorCode::kBadLayer);
  CompiledMap no_model = annotated(elsewhere(), false);
  no_model.model.bytes.clear();
  EXPECT_EQ(code_of(no_model), ErrorCode::kBadLayer);
}

}  // namespace
}  // namespace sightline
