#include "formats/map/packed_model.h"

#include <string>
#include <utility>

#include "formats/map/container/block_in_pieces.h"
#include "formats/reader/map_layout.h"

namespace sightline {
namespace {

// `stream` outlives it.
template <class Stream>
ByteSink feeding(Stream& stream) {
  return [&stream](std::span<const std::byte> piece) -> Result<void> {
    stream.add(piece);
    return {};
  };
}

// `packed` has its record, with digest.
Result<PackedModel> pack_bytes(PackedModel packed, const StoredBytes& raw) {
  SIGHTLINE_ASSIGN(BlockInPieces block, pack_in_pieces(raw));
  Xxh3Stream checksum;
  SIGHTLINE_TRY(block.bytes.visit(feeding(checksum)));
  packed.codec = block.codec;
  packed.raw_size = raw.size();
  packed.stored_checksum = checksum.finish();
  packed.block = std::move(block.bytes);
  return packed;
}

}  // namespace

Result<PackedModel> pack_model(const StoredErrorModel& model) {
  PackedModel packed;
  packed.record = card_record_of(model.head, model.training_row_count);
  Sha256Stream digest;
  SIGHTLINE_TRY(model.payload.visit(feeding(digest)));
  packed.record.digest = digest.finish();
  return pack_bytes(std::move(packed), model.payload);
}

Result<PackedModel> pack_model(ModelRecord record) {
  PackedModel packed;
  packed.record = std::move(record);
  const StoredBytes raw(std::exchange(packed.record.bytes, {}));
  return pack_bytes(std::move(packed), raw);
}

Result<PackedBlock> read_section(const PackedModel& model, std::vector<std::byte>& bytes) {
  SIGHTLINE_ASSIGN(bytes, model.block.read(0, model.block.size()));
  // The manifest names its digest, so it need not be required: a vehicle can do without it.
  return PackedBlock{std::string(kModelSection),
                     model.record.encoding_version,
                     false,
                     model.codec,
                     1,
                     model.raw_size,
                     model.stored_checksum,
                     model.record.digest,
                     bytes};
}

Result<void> validate(const PackedModel& model) {
  SIGHTLINE_TRY(validate(model.record.localizer));
  const auto wrong = [](ErrorCode code, const char* what) {
    return Error{code, "a packed model does not match its " + std::string(what)};
  };
  Xxh3Stream checksum;
  SIGHTLINE_TRY(model.block.visit(feeding(checksum)));
  if (checksum.finish() != model.stored_checksum) {
    return wrong(ErrorCode::kChecksumMismatch, "checksum");
  }
  Sha256Stream digest;
  if (model.codec == BlockCodec::kZstd) {
    SIGHTLINE_TRY(visit_unpacked_zstd(model.block, model.raw_size, feeding(digest)));
  } else if (model.codec == BlockCodec::kNone && model.raw_size == model.block.size()) {
    SIGHTLINE_TRY(model.block.visit(feeding(digest)));
  } else {
    return Error{ErrorCode::kBadLayer, "the codec is unknown or the sizes differ"};
  }
  if (digest.finish() != model.record.digest) return wrong(ErrorCode::kDigestMismatch, "digest");
  return {};
}

Table dump(const PackedModel& model) {
  Table table;
  table.name = "packed-model";
  table.facts = {{"encoding", std::int64_t{model.record.encoding_version}},
                 {"sha256", to_hex(model.record.digest)},
                 {"raw_bytes", static_cast<std::int64_t>(model.raw_size)}};
  for (const auto& [name, value] : model.record.card) table.facts.emplace_back(name, value);
  return table;
}

void BytesOf<PackedModel>::encode_head(const PackedModel& model, ByteWriter& writer) {
  const ModelRecord& record = model.record;
  writer.put(record.encoding_version);
  writer.append(record.digest.data(), record.digest.size());
  encode(record.localizer, writer);
  writer.put<std::uint64_t>(record.card.size());
  for (const auto& [name, value] : record.card) {
    writer.put_string(name);
    writer.put_string(value);
  }
  writer.put(record.mean_r_squared);
  writer.put(static_cast<std::uint8_t>(model.codec));
  writer.put(model.raw_size);
  writer.put(model.stored_checksum);
}

void BytesOf<PackedModel>::decode_head(ByteReader& reader, PackedModel& model) {
  constexpr std::size_t kLeastFact = 2 * sizeof(std::uint64_t);
  ModelRecord& record = model.record;
  reader.get(record.encoding_version);
  for (std::uint8_t& byte : record.digest) reader.get(byte);
  decode(reader, record.localizer);
  record.card.resize(reader.get_count(kLeastFact));
  for (auto& [name, value] : record.card) {
    reader.get_string(name);
    reader.get_string(value);
  }
  reader.get(record.mean_r_squared);
  model.codec = static_cast<BlockCodec>(reader.get<std::uint8_t>());
  reader.get(model.raw_size);
  reader.get(model.stored_checksum);
}

}  // namespace sightline
