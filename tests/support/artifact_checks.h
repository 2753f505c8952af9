#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "formats/artifact.h"
#include "tests/support/value_of.h"

namespace sightline {

// What the encoder of an artifact writes, without its envelope.
template <class X>
std::vector<std::byte> payload_of(const X& artifact) {
  ByteWriter writer;
  encode(artifact, writer);
  return writer.take();
}

// Three of the four ways in which each format is tested: round trip, cut short at every byte, and
// damaged at every byte. Keep `artifact` small: the work grows with the square of its size.
template <class X>
void expect_survives_disk(const X& artifact) {
  ASSERT_TRUE(validate(artifact).has_value());
  const std::vector<std::byte> bytes = to_bytes(artifact);
  const X back = value_of(from_bytes<X>(bytes));
  EXPECT_EQ(to_bytes(back), bytes) << "encode(decode(bytes)) differs";
  EXPECT_EQ(format_table(dump(back), TableFormat::kCsv),
            format_table(dump(artifact), TableFormat::kCsv));
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const Result<X> cut = from_bytes<X>(std::span(bytes).first(size));
    ASSERT_FALSE(cut.has_value()) << "accepted a file cut short at byte " << size;
  }
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::vector<std::byte> damaged = bytes;
    damaged[i] ^= std::byte{0x10};
    ASSERT_FALSE(from_bytes<X>(damaged).has_value()) << "accepted a file damaged at byte " << i;
  }
  // Below the checksum: a decoder of its own never trusts what it reads.
  const std::vector<std::byte> payload = payload_of(artifact);
  for (std::size_t size = 0; size < payload.size(); ++size) {
    ByteReader reader(std::span<const std::byte>(payload).first(size));
    X ignored;
    decode(reader, ignored);
    ASSERT_FALSE(reader.at_end() && reader.ok() && size == payload.size());
  }
  for (std::size_t i = 0; i < payload.size(); ++i) {
    std::vector<std::byte> damaged = payload;
    damaged[i] ^= std::byte{0xff};
    ByteReader reader(damaged);
    X ignored;
    decode(reader, ignored);  // must neither crash nor allocate without bound
    if (reader.at_end()) (void)validate(ignored);
  }
}

// All bytes of an artifact that is visited piece by piece.
template <class X>
std::vector<std::byte> sealed(const X& stored) {
  std::vector<std::byte> bytes;
  EXPECT_TRUE(visit_bytes(stored, [&](std::span<const std::byte> piece) -> Result<void> {
    bytes.insert(bytes.end(), piece.begin(), piece.end());
    return {};
  }));
  return bytes;
}

template <class X>
void expect_refused(const X& valid, const std::vector<std::function<void(X&)>>& changes) {
  ASSERT_TRUE(validate(valid).has_value());
  for (std::size_t i = 0; i < changes.size(); ++i) {
    X changed = valid;
    changes[i](changed);
    EXPECT_EQ(failure_of(validate(changed), i).code, ErrorCode::kInvalidArtifact) << i;
  }
}

}  // namespace sightline
