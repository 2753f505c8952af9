#include "compiler/views/picture/raster.h"
#include "tests/support/value_of.h"

#include <gtest/gtest.h>

#include <cstring>

namespace sightline {
namespace {

std::uint32_t big_endian(const std::vector<std::byte>& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    value = value << 8 | std::to_integer<std::uint32_t>(bytes.at(at + i));
  }
  return value;
}

TEST(Png, BeginsWithItsSignatureAndSize) {
  const std::vector<std::byte> file = value_of(encode_png(Raster(7, 3, {255, 0, 0})));
  ASSERT_GT(file.size(), 33U);
  EXPECT_EQ(std::memcmp(file.data(), "\x89PNG\r\n\x1a\n", 8), 0);
  EXPECT_EQ(big_endian(file, 16), 7U);
  EXPECT_EQ(big_endian(file, 20), 3U);
}

TEST(Png, HasTheSameBytesEachTime) {
  EXPECT_EQ(*encode_png(Raster(9, 9, {1, 2, 3})), *encode_png(Raster(9, 9, {1, 2, 3})));
  EXPECT_NE(*encode_png(Raster(9, 9, {1, 2, 3})), *encode_png(Raster(9, 9, {1, 2, 4})));
}

TEST(Png, RefusesAPictureOfNoSize) {
  EXPECT_EQ(encode_png(Raster(0, 5, {})).error().code, ErrorCode::kBadArgument);
}

}  // namespace
}  // namespace sightline
