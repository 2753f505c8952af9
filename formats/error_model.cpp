#include "formats/error_model.h"

#include <algorithm>
#include <cmath>

namespace sightline {
namespace {

Error invalid(const std::string& place, const std::string& message) {
  return {ErrorCode::kInvalidArtifact, message, "", place};
}

bool are_finite(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(),
                     [](double value) { return std::isfinite(value); });
}

Result<void> validate_card(const ErrorModel& model) {
  const TrainingCard& card = model.card;
  const std::vector<double> numbers = {card.feature_share, card.block_m, card.buffer_m,
                                       card.labelled_route_m};
  if (!are_finite(numbers) || *std::min_element(numbers.begin(), numbers.end()) < 0.0) {
    return invalid("model card", "found a number that is negative or not finite");
  }
  if (card.reference != ErrorReference::kKnownPose &&
      card.reference != ErrorReference::kFullRangeMatch) {
    return invalid("model card", "found an unknown reference");
  }
  if (card.places.empty() || (card.hold_out != "blocks" && card.hold_out != "places")) {
    return invalid("model card", "it names no place, or holds out neither blocks nor places");
  }
  for (const PlaceCard& place : card.places) {
    if (!std::isfinite(place.labelled_route_m) || place.labelled_route_m < 0.0) {
      return invalid("model card", "the route of place '" + place.name + "' makes no sense");
    }
  }
  if (card.tree_count != model.forest.trees.size()) {
    return invalid("model card", "found " + std::to_string(model.forest.trees.size()) +
                                     " trees, expected " + std::to_string(card.tree_count));
  }
  return {};
}

Result<void> validate_features(const ErrorModel& model) {
  if (model.features.size() != model.forest.feature_count ||
      model.features.back().name != "range_m") {
    return invalid("", "found " + std::to_string(model.features.size()) + " features, expected " +
                           std::to_string(model.forest.feature_count) + " that end in range_m");
  }
  for (const FeatureCard& feature : model.features) {
    const std::size_t count = model.ranges.size();
    if (feature.support_min.size() != count || feature.support_max.size() != count ||
        !are_finite(feature.support_min) || !are_finite(feature.support_max) ||
        !std::isfinite(feature.importance_m)) {
      return invalid("feature " + feature.name, "its support or importance makes no sense");
    }
    for (std::size_t range = 0; range < count; ++range) {
      if (feature.support_min[range] > feature.support_max[range]) {
        return invalid("feature " + feature.name, "its support ends before it begins");
      }
    }
  }
  return {};
}

Result<void> validate_ranges(const ErrorModel& model) {
  if (model.ranges.size() != model.out_of_fold.ranges_m.size()) {
    return invalid("", "the model card and the predictions name other ranges");
  }
  for (std::size_t range = 0; range < model.ranges.size(); ++range) {
    const RangeCard& card = model.ranges[range];
    if (card.range_m != model.out_of_fold.ranges_m[range] ||
        !are_finite({card.mean_error_m, card.r_squared, card.rmse_m, card.history_r_squared,
                     card.history_rmse_m})) {
      return invalid("range " + std::to_string(range), "its card makes no sense");
    }
  }
  return {};
}

Result<void> validate_sites(const ErrorModel& model) {
  const std::size_t count = model.sites.size();
  if (model.out_of_fold.site_count != count ||
      model.measured_mean_m.size() != count * model.ranges.size() ||
      !are_finite(model.measured_mean_m)) {
    return invalid("", "predictions or labels do not fill " + std::to_string(count) + " sites");
  }
  std::size_t labelled_count = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const TrainedSite& site = model.sites[i];
    const bool follows = i == 0 || model.sites[i - 1].run < site.run ||
                         (model.sites[i - 1].run == site.run && model.sites[i - 1].s_m < site.s_m);
    if (!site.p_world_m.allFinite() || !std::isfinite(site.s_m) || !follows || site.has_label > 1 ||
        site.has_history > 1 || site.place >= model.card.places.size() ||
        site.block >= model.card.block_count ||
        static_cast<std::size_t>(site.street) >= kStreetTypeCount) {
      return invalid("site " + std::to_string(i), "its place, order or block makes no sense");
    }
    labelled_count += site.has_label;
  }
  const std::size_t most_rows = labelled_count * model.ranges.size();
  if (model.forest.labels.size() > most_rows ||
      model.forest.labels.size() % model.ranges.size() != 0) {
    return invalid("", "found " + std::to_string(model.forest.labels.size()) +
                           " training rows, expected " + std::to_string(model.ranges.size()) +
                           " for each of at most " + std::to_string(labelled_count) + " sites");
  }
  return {};
}

Result<void> validate_streets(const ErrorModel& model) {
  for (std::size_t i = 0; i < model.streets.size(); ++i) {
    const StreetCard& card = model.streets[i];
    const bool is_known = card.street != StreetType::kUnknown &&
                          static_cast<std::size_t>(card.street) < kStreetTypeCount;
    const bool is_share = card.coverage >= 0.0 && card.coverage <= 1.0;
    if (!is_known || !is_share || card.case_count == 0 ||
        !are_finite({card.limit_m, card.mean_range_m, card.mean_error_m})) {
      return invalid("street type " + std::to_string(i), "its card makes no sense");
    }
  }
  return {};
}

void encode_streets(const std::vector<StreetCard>& streets, ByteWriter& writer) {
  writer.put<std::uint64_t>(streets.size());
  for (const StreetCard& card : streets) {
    writer.put(card.limit_m);
    writer.put(card.street);
    writer.put(card.case_count);
    writer.put(card.coverage);
    writer.put(card.mean_range_m);
    writer.put(card.mean_error_m);
  }
}

void decode_streets(ByteReader& reader, std::vector<StreetCard>& streets) {
  constexpr std::size_t kBytesPerStreet = 4 * sizeof(double) + 1 + 4;
  streets.resize(reader.get_count(kBytesPerStreet));
  for (StreetCard& card : streets) {
    reader.get(card.limit_m);
    reader.get(card.street);
    reader.get(card.case_count);
    reader.get(card.coverage);
    reader.get(card.mean_range_m);
    reader.get(card.mean_error_m);
  }
}

void encode_card(const TrainingCard& card, ByteWriter& writer) {
  writer.put<std::uint64_t>(card.places.size());
  for (const PlaceCard& place : card.places) {
    writer.put_string(place.name);
    writer.put<std::uint64_t>(place.drives.size());
    for (const std::string& drive : place.drives) writer.put_string(drive);
    writer.put(place.labelled_route_m);
    writer.put(place.block_count);
  }
  writer.put(card.reference);
  writer.put_string(card.feature_set);
  writer.put_string(card.hold_out);
  writer.put(card.seed);
  writer.put(card.tree_count);
  writer.put(card.least_leaf_rows);
  writer.put(card.feature_share);
  writer.put(card.block_m);
  writer.put(card.buffer_m);
  writer.put(card.labelled_route_m);
  writer.put(card.block_count);
  writer.put(card.fold_count);
  writer.put<std::uint8_t>(card.knows_history ? 1 : 0);
}

void decode_card(ByteReader& reader, TrainingCard& card) {
  constexpr std::size_t kBytesPerPlace = 2 * sizeof(std::uint64_t) + sizeof(double) + 4;
  card.places.resize(reader.get_count(kBytesPerPlace));
  for (PlaceCard& place : card.places) {
    reader.get_string(place.name);
    place.drives.resize(reader.get_count(sizeof(std::uint64_t)));
    for (std::string& drive : place.drives) reader.get_string(drive);
    reader.get(place.labelled_route_m);
    reader.get(place.block_count);
  }
  reader.get(card.reference);
  reader.get_string(card.feature_set);
  reader.get_string(card.hold_out);
  reader.get(card.seed);
  reader.get(card.tree_count);
  reader.get(card.least_leaf_rows);
  reader.get(card.feature_share);
  reader.get(card.block_m);
  reader.get(card.buffer_m);
  reader.get(card.labelled_route_m);
  reader.get(card.block_count);
  reader.get(card.fold_count);
  const auto knows_history = reader.get<std::uint8_t>();
  if (knows_history > 1) reader.fail();
  card.knows_history = knows_history == 1;
}

void decode_sites(ByteReader& reader, std::vector<TrainedSite>& sites) {
  constexpr std::size_t kBytesPerSite = 4 * sizeof(double) + 3 * 4 + 2 + 8 + 1;
  sites.resize(reader.get_count(kBytesPerSite));
  for (TrainedSite& site : sites) {
    for (int axis = 0; axis < 3; ++axis) reader.get(site.p_world_m[axis]);
    reader.get(site.place);
    reader.get(site.run);
    reader.get(site.s_m);
    reader.get(site.block);
    reader.get(site.has_label);
    reader.get(site.has_history);
    reader.get(site.factor_digest);
    reader.get(site.street);
  }
}

}  // namespace

Result<void> validate(const ErrorModel& model) {
  Result<void> valid = validate(model.forest);
  if (valid) valid = validate(model.out_of_fold);
  if (valid) valid = validate_card(model);
  if (valid) valid = validate_ranges(model);
  if (valid) valid = validate_features(model);
  if (valid) valid = validate_sites(model);
  if (valid) valid = validate_streets(model);
  return valid;
}

void encode(const ErrorModel& model, ByteWriter& writer) {
  encode_card(model.card, writer);
  writer.put<std::uint64_t>(model.features.size());
  for (const FeatureCard& feature : model.features) {
    writer.put_string(feature.name);
    writer.put(feature.importance_m);
    writer.put_array(feature.support_min);
    writer.put_array(feature.support_max);
  }
  writer.put<std::uint64_t>(model.ranges.size());
  for (const RangeCard& range : model.ranges) {
    writer.put(range.range_m);
    writer.put(range.mean_error_m);
    writer.put(range.r_squared);
    writer.put(range.rmse_m);
    writer.put(range.history_r_squared);
    writer.put(range.history_rmse_m);
  }
  encode_streets(model.streets, writer);
  encode(model.forest, writer);
  writer.put<std::uint64_t>(model.sites.size());
  for (const TrainedSite& site : model.sites) {
    for (int axis = 0; axis < 3; ++axis) writer.put(site.p_world_m[axis]);
    writer.put(site.place);
    writer.put(site.run);
    writer.put(site.s_m);
    writer.put(site.block);
    writer.put(site.has_label);
    writer.put(site.has_history);
    writer.put(site.factor_digest);
    writer.put(site.street);
  }
  encode(model.out_of_fold, writer);
  writer.put_array(model.measured_mean_m);
}

void decode(ByteReader& reader, ErrorModel& model) {
  constexpr std::size_t kBytesPerFeature = 4 * sizeof(std::uint64_t);
  constexpr std::size_t kBytesPerRange = 6 * sizeof(double);
  decode_card(reader, model.card);
  model.features.resize(reader.get_count(kBytesPerFeature));
  for (FeatureCard& feature : model.features) {
    reader.get_string(feature.name);
    reader.get(feature.importance_m);
    reader.get_array(feature.support_min);
    reader.get_array(feature.support_max);
  }
  model.ranges.resize(reader.get_count(kBytesPerRange));
  for (RangeCard& range : model.ranges) {
    reader.get(range.range_m);
    reader.get(range.mean_error_m);
    reader.get(range.r_squared);
    reader.get(range.rmse_m);
    reader.get(range.history_r_squared);
    reader.get(range.history_rmse_m);
  }
  decode_streets(reader, model.streets);
  decode(reader, model.forest);
  decode_sites(reader, model.sites);
  decode(reader, model.out_of_fold);
  reader.get_array(model.measured_mean_m);
}

}  // namespace sightline
