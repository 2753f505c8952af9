#include "formats/model/error_model.h"

// The encoding that schemas/model_format.md describes.

#include <string>

#include "formats/annotation/of_samples.h"
#include "formats/array_pieces.h"

namespace sightline {
namespace {

Error undecodable_model(std::size_t at) {
  return {ErrorCode::kBadLayer, "the payload of an error-model cannot be decoded", "",
          "payload byte " + std::to_string(at)};
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
    encode(place.recordings, writer);
  }
  writer.put(card.reference);
  encode(card.localizer, writer);
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
  writer.put(card.curve.offset);
  writer.put(card.curve.slope);
}

void decode_card(ByteReader& reader, TrainingCard& card) {
  constexpr std::size_t kBytesPerPlace = 3 * sizeof(std::uint64_t) + sizeof(double) + 4;
  card.places.resize(reader.get_count(kBytesPerPlace));
  for (PlaceCard& place : card.places) {
    reader.get_string(place.name);
    place.drives.resize(reader.get_count(sizeof(std::uint64_t)));
    for (std::string& drive : place.drives) reader.get_string(drive);
    reader.get(place.labelled_route_m);
    reader.get(place.block_count);
    decode(reader, place.recordings);
  }
  reader.get(card.reference);
  decode(reader, card.localizer);
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
  reader.get(card.curve.offset);
  reader.get(card.curve.slope);
}

void decode_sites(ByteReader& reader, std::vector<TrainedSite>& sites) {
  constexpr std::size_t kBytesPerSite = 4 * sizeof(double) + 4 * 4 + 2 + 8 + 1;
  sites.resize(reader.get_count(kBytesPerSite));
  for (TrainedSite& site : sites) {
    for (int axis = 0; axis < 3; ++axis) reader.get(site.p_world_m[axis]);
    reader.get(site.place);
    reader.get(site.drive);
    reader.get(site.run);
    reader.get(site.s_m);
    reader.get(site.block);
    reader.get(site.has_label);
    reader.get(site.has_history);
    reader.get(site.factor_digest);
    reader.get(site.street);
  }
}

void encode_sites(const std::vector<TrainedSite>& sites, ByteWriter& writer) {
  writer.put<std::uint64_t>(sites.size());
  for (const TrainedSite& site : sites) {
    for (int axis = 0; axis < 3; ++axis) writer.put(site.p_world_m[axis]);
    writer.put(site.place);
    writer.put(site.drive);
    writer.put(site.run);
    writer.put(site.s_m);
    writer.put(site.block);
    writer.put(site.has_label);
    writer.put(site.has_history);
    writer.put(site.factor_digest);
    writer.put(site.street);
  }
}

Result<void> visit_own(const ErrorModel& model, const ByteSink& sink) {
  SIGHTLINE_TRY(visit_encoded([&](ByteWriter& writer) { encode_head(model, writer); }, sink));
  SIGHTLINE_TRY(visit_behind_feature_count(model.forest, sink));
  SIGHTLINE_TRY(
      visit_encoded([&](ByteWriter& writer) { encode_sites(model.sites, writer); }, sink));
  SIGHTLINE_TRY(visit_encoded(
      [&](ByteWriter& writer) { encode_predictions(model.out_of_fold, writer); }, sink));
  return visit_array(model.measured_mean_m, sink);
}

void decode_own(ByteReader& reader, ErrorModel& model) {
  decode_head(reader, model);
  decode_behind_feature_count(reader, model.forest);
  decode_sites(reader, model.sites);
  decode_predictions(reader, model.out_of_fold);
  reader.get_array(model.measured_mean_m);
}

}  // namespace

void encode_head(const ErrorModel& model, ByteWriter& writer) {
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
  writer.put(model.forest.feature_count);
}

void decode_head(ByteReader& reader, ErrorModel& model) {
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
  reader.get(model.forest.feature_count);
}

void encode(const ErrorModel& model, ByteWriter& writer) {
  encode_by_visiting([&](const ByteSink& sink) { return visit_payload(model, sink); }, writer);
}

void decode(ByteReader& reader, ErrorModel& model) { decode_both(reader, model, decode_own); }

std::uint64_t payload_size(const ErrorModel& model) {
  ByteWriter counting = ByteWriter::that_counts();
  encode(model, counting);
  return counting.count();
}

Result<void> visit_payload(const ErrorModel& model, const ByteSink& sink) {
  return visit_both(model, sink, visit_own);
}

Result<void> open_payload(const StoredBytes& payload, ErrorModel& model) {
  SIGHTLINE_ASSIGN(const std::vector<std::byte> bytes, payload.read(0, payload.size()));
  ByteReader reader(bytes);
  decode(reader, model);
  if (!reader.at_end()) return undecodable_model(reader.offset());
  return validate(model);
}

}  // namespace sightline
