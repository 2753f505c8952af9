#include "formats/model/error_model.h"

// The encoding that schemas/model_format.md describes.

#include <string>

#include "formats/artifact.h"

namespace sightline {
namespace {

Error undecodable_model(std::size_t at) {
  return {ErrorCode::kBadLayer, "the payload of an error-model cannot be decoded", "",
          concat("payload byte ", at)};
}

template <class Model>
Result<void> open_whole(const StoredBytes& payload, Model& model) {
  SIGHTLINE_ASSIGN(const std::vector<std::byte> bytes, payload.read(0, payload.size()));
  ByteReader reader(bytes);
  decode(reader, model);
  if (!reader.at_end()) return undecodable_model(reader.offset());
  return validate(model);
}

}  // namespace

void encode_head(const ErrorModel& model, ByteWriter& writer) {
  encode(model.card, writer);
  encode(model.features, writer);
  encode(model.ranges, writer);
  encode(model.kinds, writer);
  writer.put(model.forest.feature_count);
}

void decode_head(ByteReader& reader, ErrorModel& model) {
  decode(reader, model.card);
  decode(reader, model.features);
  decode(reader, model.ranges);
  decode(reader, model.kinds);
  reader.get(model.forest.feature_count);
}

void encode(const ErrorModel& model, ByteWriter& writer) {
  encode_by_visiting([&](const ByteSink& sink) { return visit_payload(model, sink); }, writer);
}

void decode(ByteReader& reader, ErrorModel& model) {
  decode_head(reader, model);
  decode_behind_feature_count(reader, model.forest);
  decode(reader, model.sites);
  decode_predictions(reader, model.out_of_fold);
  reader.get_array(model.measured_mean_m);
  decode(reader, model.tracking);
}

std::uint64_t payload_size(const ErrorModel& model) {
  ByteWriter counting = ByteWriter::that_counts();
  encode(model, counting);
  return counting.count();
}

Result<void> visit_payload(const ErrorModel& model, const ByteSink& sink) {
  SIGHTLINE_TRY(visit_encoded([&](ByteWriter& writer) { encode_head(model, writer); }, sink));
  SIGHTLINE_TRY(visit_behind_feature_count(model.forest, sink));
  SIGHTLINE_TRY(visit_encoded([&](ByteWriter& writer) { encode(model.sites, writer); }, sink));
  SIGHTLINE_TRY(visit_encoded(
      [&](ByteWriter& writer) { encode_predictions(model.out_of_fold, writer); }, sink));
  SIGHTLINE_TRY(visit_array(model.measured_mean_m, sink));
  return visit_encoded([&](ByteWriter& writer) { encode(model.tracking, writer); }, sink);
}

Result<void> open_payload(const StoredBytes& payload, ErrorModel& model) {
  return open_whole(payload, model);
}

Result<void> open_payload(const StoredBytes& payload, ByFamily<ErrorModel>& model) {
  return open_whole(payload, model);
}

}  // namespace sightline
