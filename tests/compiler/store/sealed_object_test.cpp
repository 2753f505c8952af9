#include "compiler/store/sealed_object.h"

#include <gtest/gtest.h>

#include <string_view>

namespace sightline {
namespace {

std::vector<std::byte> bytes_of(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
  return {bytes.begin(), bytes.end()};
}

const ObjectName kName{"measure-error part 3", sha256("key")};

// A byte at a time.
std::vector<std::byte> sealed(std::string_view content) {
  std::vector<std::byte> object;
  const auto bytes = bytes_of(content);
  const auto byte_by_byte = [&](const ByteSink& sink) -> Result<void> {
    for (const std::byte& byte : bytes) SIGHTLINE_TRY(sink(std::span(&byte, 1)));
    return {};
  };
  EXPECT_TRUE(write_sealed(kName, byte_by_byte, [&](std::span<const std::byte> piece) {
    object.insert(object.end(), piece.begin(), piece.end());
    return Result<void>();
  }));
  return object;
}

Result<SealedObject> open_object(std::vector<std::byte> bytes) {
  return open_object(StoredBytes(std::move(bytes)));
}

TEST(SealedObject, SaysWhatItIsAndHoldsWhatWasSealed) {
  for (const std::string_view content : {"", "x", "some content"}) {
    const std::vector<std::byte> object = sealed(content);
    const Result<SealedObject> opened = open_object(object);
    ASSERT_TRUE(opened);
    EXPECT_EQ(opened->name, kName);
    EXPECT_EQ(*opened->content.read(0, opened->content.size()), bytes_of(content));
  }
}

TEST(SealedObject, IsRefusedCutShortAtEveryByte) {
  const std::vector<std::byte> object = sealed("some content");
  for (std::size_t size = 0; size < object.size(); ++size) {
    const auto cut = object.begin() + static_cast<std::ptrdiff_t>(size);
    EXPECT_FALSE(open_object(std::vector(object.begin(), cut))) << size;
    EXPECT_FALSE(open_object(std::vector(cut + 1, object.end()))) << size;
  }
}

TEST(SealedObject, IsRefusedDamagedAtEveryBit) {
  const std::vector<std::byte> object = sealed("some content");
  for (std::size_t i = 0; i < 8 * object.size(); ++i) {
    std::vector<std::byte> damaged = object;
    damaged[i / 8] ^= std::byte{1} << (i % 8);
    EXPECT_FALSE(open_object(damaged)) << i;
  }
}

}  // namespace
}  // namespace sightline
