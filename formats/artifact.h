#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/bytes.h"
#include "formats/base/result.h"
#include "formats/record/codec.h"
#include "formats/text/table.h"

// What every artifact has, found by overload (X is the artifact's struct, all in its own pair of
// files formats/x.{h,cpp}):
//
//   SIGHTLINE_FIELDS(X, ...)                               // record/fields.h: its encoding
//   template <> struct ArtifactTraits<X> {
//     static constexpr std::string_view kName = "x";       // kebab-case, also in messages
//     static constexpr std::uint32_t kVersion = 1;         // of the encoding
//   };
//   Result<void> validate(const X&);                       // every invariant the struct promises
//   Table dump(const X&);                                  // every number there is
//
// Where fields alone do not say how it is encoded it has encode(const X&, ByteWriter&) and
// decode(ByteReader&, X&) of its own; decode calls reader.fail() where bytes make no sense.
//
// In memory an artifact never changes once made. On disk (the cache) it lies in an envelope that
// names its type and version and carries a checksum.

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
    return Error{ErrorCode::kBadLayer,
                 "the payload of a " + std::string(ArtifactTraits<X>::kName) + " cannot be decoded",
                 "", "payload byte " + std::to_string(reader.offset())};
  }
  SIGHTLINE_TRY(validate(artifact));
  return artifact;
}

}  // namespace sightline
