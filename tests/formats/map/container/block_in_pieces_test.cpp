#include "formats/map/container/block_in_pieces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "formats/base/random.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

std::vector<std::byte> read_all(const StoredBytes& stored) {
  const Result<std::vector<std::byte>> bytes = stored.read(0, stored.size());
  EXPECT_TRUE(bytes);
  return bytes ? *bytes : std::vector<std::byte>();
}

std::vector<std::byte> noise(std::size_t size) {
  Random random(size);
  std::vector<std::byte> bytes(size);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random.below(256));
  return bytes;
}

// Noise, half of it copies of what came before, near and far.
std::vector<std::byte> packable(std::size_t size) {
  constexpr std::size_t kPiece = 4096;
  Random random(size);
  std::vector<std::byte> bytes = noise(size);
  for (std::size_t at = kPiece; at + kPiece <= size; at += 2 * kPiece) {
    const auto from = static_cast<std::ptrdiff_t>(random.below(at - kPiece + 1));
    std::copy_n(bytes.begin() + from, kPiece, bytes.begin() + static_cast<std::ptrdiff_t>(at));
  }
  return bytes;
}

void expect_as_whole(const std::vector<std::byte>& raw) {
  const BlockInPieces pieces = value_of(pack_in_pieces(StoredBytes(raw)), raw.size());
  const StoredBlock whole = pack(raw);
  EXPECT_EQ(pieces.codec, whole.codec) << raw.size();
  if (raw.size() <= kPackedPiece) {
    EXPECT_TRUE(read_all(pieces.bytes) == whole.bytes) << raw.size();
  } else {
    EXPECT_LE(pieces.bytes.size(), whole.bytes.size() + whole.bytes.size() / 100) << raw.size();
    const auto unpacked = unpack_zstd(read_all(pieces.bytes), raw.size());
    EXPECT_TRUE(unpacked && *unpacked == raw) << raw.size();
  }
  if (whole.codec != BlockCodec::kZstd) return;
  std::vector<std::byte> back;
  require(visit_unpacked_zstd(pieces.bytes, raw.size(),
                              [&](std::span<const std::byte> piece) -> Result<void> {
                                back.insert(back.end(), piece.begin(), piece.end());
                                return {};
                              }));
  EXPECT_TRUE(back == raw) << raw.size();
}

// The last but one is longer than pack()'s window of 4 MiB, the last than any.
TEST(BlockInPieces, HoldsWhatABlockThatIsPackedWholeDoes) {
  for (const std::size_t size :
       {0UL, 1UL, 100UL, 1UL << 20U, (1UL << 20U) + 1, 6'400'001UL, 9'000'000UL}) {
    expect_as_whole(packable(size));
  }
  expect_as_whole(noise(300'000));
}

TEST(BlockInPieces, ThatIsCutOrFollowedOrOfAnotherSizeCannotBeUnpacked) {
  const std::vector<std::byte> raw = packable(300'000);
  std::vector<std::byte> stored = pack(raw).bytes;
  const auto code_of = [&](const std::vector<std::byte>& bytes, std::uint64_t raw_size) {
    const Result<void> read =
        visit_unpacked_zstd(StoredBytes(bytes), raw_size,
                            [](std::span<const std::byte>) -> Result<void> { return {}; });
    return read ? ErrorCode{} : read.error().code;
  };
  EXPECT_EQ(code_of(stored, raw.size()), ErrorCode{});
  EXPECT_EQ(code_of(stored, raw.size() + 1), ErrorCode::kBadLayer);
  EXPECT_EQ(code_of(stored, std::uint64_t{1} << 31U), ErrorCode::kTooLarge);
  stored.push_back(std::byte{0});
  EXPECT_EQ(code_of(stored, raw.size()), ErrorCode::kBadLayer);
  stored.pop_back();
  for (std::size_t size = 0; size < stored.size(); size += 1 + size / 7) {
    const std::vector<std::byte> cut(stored.begin(),
                                     stored.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_NE(code_of(cut, raw.size()), ErrorCode{}) << size;
  }
}

}  // namespace
}  // namespace sightline
