#pragma once

#include <concepts>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/bytes.h"
#include "formats/base/files/stored_bytes.h"
#include "formats/base/result.h"
#include "formats/record/codec.h"
#include "formats/text/table.h"

// What every artifact has, found by overload (X is the artifact's struct, all in its own pair of
// files formats/x.{h,cpp}):
//
//   SIGHTLINE_FIELDS(X, ...)                               // record/fields.h: its encoding
//   SIGHTLINE_ARTIFACT(X, "x", 1)                          // its name, kebab-case, also in
//                                                          // messages; version of the encoding
//   Result<void> validate(const X&);                       // every invariant the struct promises
//   Table dump(const X&);                                  // every number there is
//
// Where fields alone do not say how it is encoded it has encode(const X&, ByteWriter&) and
// decode(ByteReader&, X&) of its own; decode calls reader.fail() where bytes make no sense. An
// artifact that memory should not hold whole has these in their place:
//
//   std::uint64_t payload_size(const X&);
//   Result<void> visit_payload(const X&, const ByteSink&);   // so many bytes, piece by piece
//   Result<void> open_payload(const StoredBytes&, X&);       // checks all, reads on when asked
//
// In memory an artifact never changes once made. On disk (the cache) it lies in an envelope that
// names its type and version and carries a checksum.

// In namespace sightline, behind the definition of X.
#define SIGHTLINE_ARTIFACT(X, name, version)           \
  template <>                                          \
  struct ArtifactTraits<X> {                           \
    static constexpr std::string_view kName = name;    \
    static constexpr std::uint32_t kVersion = version; \
  };

namespace sightline {

template <class X>
struct ArtifactTraits;

// Envelope: magic "SLA\x1a", u32 encoding version, name, payload, XXH3 of all before it.
std::vector<std::byte> seal(std::string_view name, std::uint32_t version,
                            std::vector<std::byte> payload);
// The payload within the sealed bytes, after every check. Errors: bad-magic, truncated-file,
// checksum-mismatch, bad-layer (another artifact's name), old-version, future-version.
Result<std::span<const std::byte>> unseal(std::span<const std::byte> sealed, std::string_view name,
                                          std::uint32_t version);

struct PayloadInPieces {
  std::uint64_t size = 0;
  std::function<Result<void>(const ByteSink&)> visit;
};
// What seal() returns, piece by piece. Errors: those of the payload and of the sink.
Result<void> seal_in_pieces(std::string_view name, std::uint32_t version,
                            const PayloadInPieces& payload, const ByteSink& sink);
// The payload within the sealed bytes, which are read once for all checks. Errors: also
// cannot-read.
Result<StoredBytes> unseal(const StoredBytes& sealed, std::string_view name, std::uint32_t version);

template <class X>
Error undecodable() {
  return {ErrorCode::kBadLayer,
          "the payload of a " + std::string(ArtifactTraits<X>::kName) + " cannot be decoded"};
}

// In memory that is taken once: an artifact may be a large part of what there is.
template <class X>
std::vector<std::byte> to_bytes(const X& artifact) {
  constexpr std::size_t kRoomForEnvelope = 256;
  ByteWriter counting = ByteWriter::that_counts();
  encode(artifact, counting);
  ByteWriter writer;
  writer.reserve(counting.count() + kRoomForEnvelope);
  encode(artifact, writer);
  return seal(ArtifactTraits<X>::kName, ArtifactTraits<X>::kVersion, writer.take());
}

template <class X>
Result<X> from_bytes(std::span<const std::byte> bytes) {
  SIGHTLINE_ASSIGN(const std::span<const std::byte> payload,
                   unseal(bytes, ArtifactTraits<X>::kName, ArtifactTraits<X>::kVersion));
  ByteReader reader(payload);
  X artifact;
  decode(reader, artifact);
  if (!reader.at_end()) {
    Error error = undecodable<X>();
    error.place = "payload byte " + std::to_string(reader.offset());
    return error;
  }
  SIGHTLINE_TRY(validate(artifact));
  return artifact;
}

template <class X>
concept InPieces = requires(const X& artifact, const ByteSink& sink, const StoredBytes& bytes,
                            X& out) {
  { payload_size(artifact) } -> std::same_as<std::uint64_t>;
  visit_payload(artifact, sink);
  open_payload(bytes, out);
};

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

// Decodes what begins a payload, of which as much is read as `decode` takes, and returns the place
// behind it; none where the bytes make no sense. Error: cannot-read.
Result<std::optional<std::uint64_t>> decode_front(const StoredBytes& payload,
                                                  const std::function<void(ByteReader&)>& decode);

// What ByteWriter::put_array writes. Errors: those of the sink.
template <class T>
requires std::is_trivially_copyable_v<T> Result<void> visit_array(const std::vector<T>& values,
                                                                  const ByteSink& sink) {
  const std::uint64_t count = values.size();
  SIGHTLINE_TRY(sink(std::as_bytes(std::span(&count, 1))));
  return sink(std::as_bytes(std::span(values)));
}

// What `encode` writes into a ByteWriter, as one piece, in memory that is taken once.
template <class Encode>
Result<void> visit_encoded(const Encode& encode, const ByteSink& sink) {
  ByteWriter counting = ByteWriter::that_counts();
  encode(counting);
  ByteWriter writer;
  writer.reserve(counting.count());
  encode(writer);
  return sink(writer.bytes());
}

// What visits an artifact, into a writer: the two cannot differ. `visit` fails where its sink does.
template <class Visit>
void encode_by_visiting(const Visit& visit, ByteWriter& writer) {
  const Result<void> written = visit([&](std::span<const std::byte> piece) -> Result<void> {
    writer.append(piece.data(), piece.size());
    return {};
  });
  SIGHTLINE_CHECK(written);
}

}  // namespace sightline
