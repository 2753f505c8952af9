#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "formats/base/files/stored_bytes.h"
#include "formats/map/compiled_map.h"
#include "formats/map/container/packed_block.h"
#include "formats/model/stored_error_model.h"
#include "formats/tables/head_and_bytes.h"

namespace sightline {

// An error model, ready for a map file: who writes one does not hold the model, which knows every
// site that it was trained on.
struct PackedModel {
  ModelRecord record;  // without its bytes
  // The block of section "error-model".
  BlockCodec codec = BlockCodec::kNone;
  std::uint64_t raw_size = 0;
  std::uint64_t stored_checksum = 0;
  StoredBytes block;
};
SIGHTLINE_SOME_FIELDS(PackedModel, record, codec, raw_size, stored_checksum)
template <>
inline constexpr auto kBytesOf<PackedModel> = &PackedModel::block;
SIGHTLINE_ARTIFACT(PackedModel, "packed-model", 3)

// Errors: cannot-read, disk-full, cannot-write (temporary files), out-of-memory.
Result<PackedModel> pack_model(const StoredErrorModel& model);
Result<PackedModel> pack_model(ModelRecord record);

// The section as container_writer.h takes it; what is stored lies in `bytes`. Error: cannot-read.
Result<PackedBlock> read_section(const PackedModel& model, std::vector<std::byte>& bytes);

// Unpacks the block, piece by piece. Its content is what record_of() says, or digest-mismatch.
Result<void> validate(const PackedModel& model);
Table dump(const PackedModel& model);  // facts: the model card

}  // namespace sightline
