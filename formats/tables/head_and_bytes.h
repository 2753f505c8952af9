#pragma once

#include <concepts>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "formats/artifact.h"

// An artifact of fields in memory and bytes of any size, in memory or in a file, that are read when
// they are needed. Beside it, with its bytes and no other member left out of the fields:
//
//   SIGHTLINE_SOME_FIELDS(X, ...)
//   template <>
//   inline constexpr auto kBytesOf<X> = &X::bytes;

namespace sightline {

template <class X>
inline constexpr auto kBytesOf = nullptr;

template <class X>
concept HasBytes = std::same_as<decltype(kBytesOf<X>), StoredBytes X::*const>;

template <HasBytes X>
std::vector<std::byte> head_bytes(const X& artifact) {
  ByteWriter writer;
  FieldWriter(writer).put(artifact);
  return writer.take();
}

template <HasBytes X>
std::uint64_t payload_size(const X& artifact) {
  return head_bytes(artifact).size() + (artifact.*kBytesOf<X>).size();
}

template <HasBytes X>
Result<void> visit_payload(const X& artifact, const ByteSink& sink) {
  SIGHTLINE_TRY(sink(head_bytes(artifact)));
  return (artifact.*kBytesOf<X>).visit(sink);
}

template <HasBytes X>
Result<void> open_payload(const StoredBytes& payload, X& artifact) {
  X opened;
  const auto decode = [&](ByteReader& reader) {
    opened = X();
    FieldReader(reader).get(opened);
  };
  SIGHTLINE_ASSIGN(const std::optional<std::uint64_t> begin, decode_front(payload, decode));
  if (!begin) return undecodable<X>();
  opened.*kBytesOf<X> = payload.part(*begin, payload.size() - *begin);
  SIGHTLINE_TRY(validate(opened));
  artifact = std::move(opened);
  return {};
}

}  // namespace sightline
