#include "formats/model/error_model.h"

#include <algorithm>

#include "formats/record/fields.h"

namespace sightline {
namespace {

Result<void> validate_card(const ErrorModel& model) {
  const TrainingCard& card = model.card;
  const double least =
      std::min({card.feature_share, card.block_m, card.buffer_m, card.labelled_route_m});
  if (!are_finite(card) || least < 0.0) {
    return invalid_artifact("found a number that is negative or not finite", "model card");
  }
  if (card.curve.slope <= 0.0) {
    return invalid_artifact("the curve of its probabilities does not increase", "model card");
  }
  if (card.worlds != "recorded" && !card.is_of_generated_worlds()) {
    return invalid_artifact("its worlds are neither recorded nor generated", "model card");
  }
  SIGHTLINE_TRY(validate(card.localizer));
  if (card.places.empty() ||
      (card.hold_out != "blocks" && card.hold_out != "drives" && card.hold_out != "places")) {
    return invalid_artifact("it has no place, or no held-out blocks, drives or places",
                            "model card");
  }
  for (const PlaceCard& place : card.places) {
    if (place.labelled_route_m < 0.0) {
      return invalid_artifact(concat("the route of place '", place.name, "' is out of range"),
                              "model card");
    }
    const std::size_t numbered = place.recording_numbers.size();
    if (numbered != 0 && numbered != place.recordings.cards.size()) {
      return invalid_artifact(
          concat("the recordings of place '", place.name, "' and their numbers differ in count"),
          "model card");
    }
    const Result<void> named = validate(place.recordings);
    if (!named) {
      return invalid_artifact(named.error().message, concat("model card, place '", place.name,
                                                            "', ", named.error().place));
    }
  }
  if (card.tree_count != model.forest.trees.size()) {
    return invalid_artifact(
        concat("found ", model.forest.trees.size(), " trees, expected ", card.tree_count),
        "model card");
  }
  return {};
}

Result<void> validate_features(const ErrorModel& model) {
  if (model.features.size() != model.forest.feature_count ||
      model.features.back().name != "range_m") {
    return invalid_artifact(concat("found ", model.features.size(), " features, expected ",
                                   model.forest.feature_count, " that end in range_m"),
                            "");
  }
  for (const FeatureCard& feature : model.features) {
    const std::size_t count = model.ranges.size();
    if (feature.support_min.size() != count || feature.support_max.size() != count ||
        !are_finite(feature)) {
      return invalid_artifact("its support or importance is out of range",
                              "feature " + feature.name);
    }
    for (std::size_t range = 0; range < count; ++range) {
      if (feature.support_min[range] > feature.support_max[range]) {
        return invalid_artifact("the end of its support is below the beginning",
                                "feature " + feature.name);
      }
    }
  }
  return {};
}

Result<void> validate_ranges(const ErrorModel& model) {
  if (model.ranges.size() != model.out_of_fold.looks.size()) {
    return invalid_artifact("the ranges of the model card and of the predictions differ", "");
  }
  for (std::size_t range = 0; range < model.ranges.size(); ++range) {
    const RangeCard& card = model.ranges[range];
    if (card.range_m != model.out_of_fold.looks[range].range_m || !are_finite(card)) {
      return invalid_artifact("a number of its card is out of range", concat("range ", range));
    }
  }
  return {};
}

Result<void> validate_sites(const ErrorModel& model) {
  const std::size_t count = model.sites.size();
  if (model.out_of_fold.site_count != count ||
      model.measured_mean_m.size() != model.shape().size(count) ||
      !are_finite(model.measured_mean_m)) {
    return invalid_artifact(concat("predictions or labels do not fill ", count, " sites"), "");
  }
  std::size_t labelled_count = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const TrainedSite& site = model.sites[i];
    const bool follows = i == 0 || model.sites[i - 1].run < site.run ||
                         (model.sites[i - 1].run == site.run && model.sites[i - 1].s_m < site.s_m);
    if (!are_finite(site) || !follows || site.has_label > 1 || site.has_history > 1 ||
        site.place >= model.card.places.size() ||
        site.drive >= model.card.places[site.place].drives.size() ||
        site.block >= model.card.block_count) {
      return invalid_artifact("its place, order or block is invalid", concat("site ", i));
    }
    labelled_count += site.has_label;
  }
  const std::size_t most_rows = model.shape().size(labelled_count);
  if (model.forest.labels.size() > most_rows ||
      model.forest.labels.size() % model.ranges.size() != 0) {
    return invalid_artifact(
        concat("found ", model.forest.labels.size(), " training rows, expected ",
               model.ranges.size(), " for each of at most ", labelled_count, " sites"),
        "");
  }
  return {};
}

Result<void> validate_tracking(const ErrorModel& model) {
  const TrackingLabels& tracking = model.tracking;
  if (tracking.is_empty()) {
    const bool is_none = tracking.measured_m.empty() && tracking.mean_m.empty() &&
                         tracking.within_probability.empty();
    if (is_none) return {};
    return invalid_artifact("labels from tracking starts have no training rows", "");
  }
  const std::size_t count = model.sites.size();
  const auto is_share = [](float value) { return value >= 0.0F && value <= 1.0F; };
  const bool is_of_model =
      tracking.row_errors_m.size() == model.forest.labels.size() &&
      tracking.measured_m.size() == model.shape().size(count) &&
      tracking.mean_m.size() == tracking.measured_m.size() &&
      tracking.within_probability.size() == model.out_of_fold.within_probability.size();
  const bool is_in_range = are_finite(tracking) && tracking.curve.slope > 0.0 &&
                           std::ranges::all_of(tracking.within_probability, is_share);
  if (is_of_model && is_in_range) return {};
  return invalid_artifact(
      concat("labels or predictions from tracking starts do not fill ", count, " sites"), "");
}

Result<void> validate_kinds(const ErrorModel& model) {
  for (std::size_t i = 0; i < model.kinds.size(); ++i) {
    const KindCard& card = model.kinds[i];
    const bool is_share = card.coverage >= 0.0 && card.coverage <= 1.0;
    if (card.kind == PlaceKind::kUnknown || !is_share || card.case_count == 0 ||
        !are_finite(card)) {
      return invalid_artifact("a number of its card is out of range", concat("kind of place ", i));
    }
  }
  return {};
}

bool is_of_map(const RecordingCard& card) { return card.role.starts_with("map"); }

}  // namespace

std::vector<std::size_t> recordings_of_drives(const RecordingCards& recordings,
                                              std::size_t drive_count) {
  std::vector<std::size_t> localized;
  for (std::size_t i = 0; i < recordings.cards.size(); ++i) {
    if (!is_of_map(recordings.cards[i])) localized.push_back(i);
  }
  const auto mapping = std::ranges::find_if(recordings.cards, is_of_map);
  if (localized.size() + 1 == drive_count && mapping != recordings.cards.end()) {
    localized.insert(localized.begin(),
                     static_cast<std::size_t>(mapping - recordings.cards.begin()));
  }
  return localized.size() == drive_count ? localized : std::vector<std::size_t>();
}

bool made_the_map(const RecordingCards& recordings, std::span<const std::uint32_t> numbers,
                  std::size_t recording) {
  for (std::size_t i = 0; i < recordings.cards.size(); ++i) {
    if (is_of_map(recordings.cards[i]) && numbers[i] == numbers[recording]) return true;
  }
  return false;
}

Result<void> validate(const ErrorModel& model) {
  Result<void> valid = validate(model.forest);
  if (valid) valid = validate(model.out_of_fold);
  if (valid) valid = validate_card(model);
  if (valid) valid = validate_ranges(model);
  if (valid) valid = validate_features(model);
  if (valid) valid = validate_sites(model);
  if (valid) valid = validate_kinds(model);
  if (valid) valid = validate_tracking(model);
  return valid;
}

}  // namespace sightline
