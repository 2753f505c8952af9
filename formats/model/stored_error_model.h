#pragma once

#include <cstdint>

#include "formats/base/files/stored_bytes.h"
#include "formats/model/error_model.h"

namespace sightline {

// Error models by family, of which no more than the card of the ranges' is read: the training rows,
// trees and sites stay encoded, in a file where they came from one.
struct StoredErrorModel {
  ErrorModel head;  // of the ranges: what decode_head reads
  std::uint64_t training_row_count = 0;
  StoredBytes payload;  // all of it, as encode() writes it
};

// A form of ByFamily<ErrorModel>.
template <>
struct ArtifactTraits<StoredErrorModel> {
  using Artifact = ByFamily<ErrorModel>;
  static constexpr std::string_view kName = ArtifactTraits<ErrorModel>::kName;
  static constexpr std::uint32_t kVersion = ArtifactTraits<ErrorModel>::kVersion;
};

// Of the head alone.
Result<void> validate(const StoredErrorModel& model);
Table dump(const StoredErrorModel& model);  // facts: the model card
std::uint64_t payload_size(const StoredErrorModel& model);
Result<void> visit_payload(const StoredErrorModel& model, const ByteSink& sink);
// Errors: cannot-read; bad-layer where the head cannot be decoded.
Result<void> open_payload(const StoredBytes& payload, StoredErrorModel& model);

}  // namespace sightline
