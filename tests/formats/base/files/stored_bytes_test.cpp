#include "formats/base/files/stored_bytes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include "formats/base/hash.h"
#include "formats/base/random.h"
#include "tests/support/test_files.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

std::vector<std::byte> random_bytes(std::size_t size) {
  Random random(size);
  std::vector<std::byte> bytes(size);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random.uniform(0.0, 256.0));
  return bytes;
}

GrowingBytes grown(std::span<const std::byte> bytes, std::size_t most_in_memory) {
  GrowingBytes growing(most_in_memory);
  for (std::size_t first = 0, step = 1; first < bytes.size(); first += step, step = 3 * step + 1) {
    EXPECT_TRUE(growing.append(bytes.subspan(first, std::min(step, bytes.size() - first))));
  }
  return growing;
}

TEST(StoredBytes, AreTheSameInMemoryAndInAFile) {
  const std::vector<std::byte> bytes = random_bytes(3'000'000);
  for (const std::size_t most : {std::size_t{0}, std::size_t{1000}, bytes.size()}) {
    GrowingBytes growing = grown(bytes, most);
    EXPECT_EQ(growing.is_in_file(), most < bytes.size());
    EXPECT_EQ(growing.size(), bytes.size());
    const StoredBytes stored = growing.take();
    ASSERT_EQ(stored.size(), bytes.size());
    EXPECT_TRUE(*stored.read(0, bytes.size()) == bytes);
    const StoredBytes part = stored.part(1'000'001, 1'500'000).part(10, 100);
    const auto expected = std::span(bytes).subspan(1'000'011, 100);
    EXPECT_TRUE(std::ranges::equal(*part.read(0, 100), expected));
    EXPECT_TRUE(std::ranges::equal(*part.read(99, 1), expected.last(1)));
    std::vector<std::byte> visited;
    ASSERT_TRUE(stored.visit([&](std::span<const std::byte> piece) -> Result<void> {
      EXPECT_LE(piece.size(), std::size_t{1} << 20);
      visited.insert(visited.end(), piece.begin(), piece.end());
      return {};
    }));
    EXPECT_TRUE(visited == bytes);
  }
}

TEST(StoredBytes, StopAtTheFirstFailureOfTheSink) {
  const StoredBytes stored(random_bytes(3'000'000));
  int calls = 0;
  const Result<void> visited = stored.visit([&](std::span<const std::byte>) -> Result<void> {
    ++calls;
    return Error{ErrorCode::kDiskFull, ""};
  });
  EXPECT_EQ(visited.error().code, ErrorCode::kDiskFull);
  EXPECT_EQ(calls, 1);
}

TEST(StoredBytes, MayBeNone) {
  EXPECT_EQ(StoredBytes().size(), 0U);
  EXPECT_TRUE(StoredBytes().read(0, 0)->empty());
  GrowingBytes growing;
  EXPECT_EQ(growing.take().size(), 0U);
}

TEST(GrowingBytes, TakeOthersInPlaceOfWhatIsThere) {
  std::vector<std::byte> bytes = random_bytes(100'000);
  for (const std::size_t most : {std::size_t{0}, bytes.size()}) {
    GrowingBytes growing = grown(bytes, most);
    const std::vector<std::byte> start(128, std::byte{7});
    ASSERT_TRUE(growing.replace(0, start));
    ASSERT_TRUE(growing.replace(bytes.size() - 128, start));
    ASSERT_TRUE(growing.append(start));
    const StoredBytes stored = growing.take();
    ASSERT_EQ(stored.size(), bytes.size() + 128);
    std::vector<std::byte> expected = bytes;
    std::ranges::copy(start, expected.begin());
    std::ranges::copy(start, expected.end() - 128);
    expected.insert(expected.end(), start.begin(), start.end());
    EXPECT_TRUE(*stored.read(0, stored.size()) == expected);
  }
}

TEST(GrowingBytes, SayWhereTheyCouldNotBeKept) {
  const char* const before = std::getenv("TMPDIR");
  const std::string kept = before != nullptr ? before : "";
  ::setenv("TMPDIR", "/nowhere/at/all", 1);
  GrowingBytes growing(10);
  EXPECT_TRUE(growing.append(random_bytes(10)));
  const Result<void> full = growing.append(random_bytes(1));
  before != nullptr ? ::setenv("TMPDIR", kept.c_str(), 1) : ::unsetenv("TMPDIR");
  // The standard library takes another folder where that is none.
  if (!full) {
    EXPECT_EQ(full.error().code, ErrorCode::kCannotWrite);
    EXPECT_FALSE(full.error().file.empty());
  }
}

TEST(GrowingBytes, SayThatTheDiskIsFull) {
  const NoLargeFiles full_disk;
  GrowingBytes growing(10);
  EXPECT_EQ(code_of(growing.append(random_bytes(2000))), ErrorCode::kDiskFull);
}

TEST(Xxh3Stream, IsThatOfAllBytesAtOnce) {
  const std::vector<std::byte> bytes = random_bytes(10'000);
  Xxh3Stream stream;
  for (std::size_t first = 0, step = 1; first < bytes.size(); first += step, step = 3 * step) {
    stream.add(std::span(bytes).subspan(first, std::min(step, bytes.size() - first)));
  }
  EXPECT_EQ(stream.finish(), xxh3(bytes));
}

}  // namespace
}  // namespace sightline
