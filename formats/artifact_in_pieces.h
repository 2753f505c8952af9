#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>
#include <utility>

#include "formats/artifact.h"
#include "formats/base/files/stored_bytes.h"

// An artifact that memory should not hold whole has these in place of encode and decode:
//
//   std::uint64_t payload_size(const X&);
//   Result<void> visit_payload(const X&, const ByteSink&);   // so many bytes, piece by piece
//   Result<void> open_payload(const StoredBytes&, X&);       // checks all, reads on when asked
//
// Its envelope is that of formats/artifact.h.

namespace sightline {

template <class X>
concept InPieces = requires(const X& artifact, const ByteSink& sink, const StoredBytes& bytes,
                            X& out) {
  { payload_size(artifact) } -> std::same_as<std::uint64_t>;
  visit_payload(artifact, sink);
  open_payload(bytes, out);
};

struct PayloadInPieces {
  std::uint64_t size = 0;
  std::function<Result<void>(const ByteSink&)> visit;
};

// What seal() returns, piece by piece. Errors: those of the payload and of the sink.
Result<void> seal_in_pieces(std::string_view name, std::uint32_t version,
                            const PayloadInPieces& payload, const ByteSink& sink);
// The payload within the sealed bytes, which are read once for the checks of unseal(). Errors:
// those of unseal(), cannot-read.
Result<StoredBytes> unseal(const StoredBytes& sealed, std::string_view name, std::uint32_t version);

// Decodes what begins a payload, of which as much is read as `decode` takes, and returns the place
// behind it; none where the bytes make no sense. Error: cannot-read.
Result<std::optional<std::uint64_t>> decode_front(const StoredBytes& payload,
                                                  const std::function<void(ByteReader&)>& decode);

template <InPieces X>
Result<void> visit_bytes(const X& artifact, const ByteSink& sink) {
  const auto visit = [&](const ByteSink& into) { return visit_payload(artifact, into); };
  return seal_in_pieces(ArtifactTraits<X>::kName, ArtifactTraits<X>::kVersion,
                        {payload_size(artifact), visit}, sink);
}

template <InPieces X>
Result<X> from_stored(const StoredBytes& bytes) {
  SIGHTLINE_ASSIGN(const StoredBytes payload,
                   unseal(bytes, ArtifactTraits<X>::kName, ArtifactTraits<X>::kVersion));
  X artifact;
  SIGHTLINE_TRY(open_payload(payload, artifact));
  return artifact;
}

}  // namespace sightline
