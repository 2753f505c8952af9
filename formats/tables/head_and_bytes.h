#pragma once

#include <concepts>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "formats/artifact_in_pieces.h"
#include "formats/base/files/stored_bytes.h"

// An artifact of a head in memory and bytes of any size, in memory or in a file, that are read when
// they are needed. Beside it:
//
//   template <> struct BytesOf<X> {
//     static constexpr StoredBytes X::*kBytes = ...;
//     static void encode_head(const X&, ByteWriter&);
//     static void decode_head(ByteReader&, X&);
//   };

namespace sightline {

template <class X>
struct BytesOf;

template <class X>
concept HasBytes = std::same_as<decltype(BytesOf<X>::kBytes), StoredBytes X::*const>;

template <HasBytes X>
std::vector<std::byte> head_bytes(const X& artifact) {
  ByteWriter writer;
  BytesOf<X>::encode_head(artifact, writer);
  return writer.take();
}

template <HasBytes X>
std::uint64_t payload_size(const X& artifact) {
  return head_bytes(artifact).size() + (artifact.*BytesOf<X>::kBytes).size();
}

template <HasBytes X>
Result<void> visit_payload(const X& artifact, const ByteSink& sink) {
  SIGHTLINE_TRY(sink(head_bytes(artifact)));
  return (artifact.*BytesOf<X>::kBytes).visit(sink);
}

template <HasBytes X>
Result<void> open_payload(const StoredBytes& payload, X& artifact) {
  X opened;
  const auto decode = [&](ByteReader& reader) {
    opened = X();
    BytesOf<X>::decode_head(reader, opened);
  };
  SIGHTLINE_ASSIGN(const std::optional<std::uint64_t> begin, decode_front(payload, decode));
  if (!begin) {
    return Error{ErrorCode::kBadLayer, "the payload of a " + std::string(ArtifactTraits<X>::kName) +
                                           " cannot be decoded"};
  }
  opened.*BytesOf<X>::kBytes = payload.part(*begin, payload.size() - *begin);
  SIGHTLINE_TRY(validate(opened));
  artifact = std::move(opened);
  return {};
}

}  // namespace sightline
