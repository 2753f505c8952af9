#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "formats/base/bytes.h"
#include "formats/base/files/byte_sink.h"

// Parts of an artifact that is handed over piece by piece (formats/artifact_in_pieces.h).

namespace sightline {

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
