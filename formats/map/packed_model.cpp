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
  Table table{"packed-model", {}, {}, {}};
  table.facts = {{"encoding", std::int64_t{model.record.encoding_version}},
                 {"sha256", to_hex(model.record.digest)},
                 {"raw_bytes", static_cast<std::int64_t>(model.raw_size)}};
  for (const auto& [name, value] : model.record.card) table.facts.emplace_back(name, value);
  return table;
}

}  // namespace sightline
