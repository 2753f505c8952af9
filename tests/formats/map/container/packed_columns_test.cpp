#include "formats/map/container/packed_columns.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/base/random.h"
#include "formats/reader/map_layout.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

std::vector<ArrayShape> random_shapes(Random& random, std::uint64_t rows) {
  std::vector<ArrayShape> shapes(1 + random.below(6));
  for (ArrayShape& shape : shapes) {
    shape = {rows, static_cast<std::uint32_t>(random.below(5)), 1U << random.below(4)};
  }
  return shapes;
}

std::vector<std::byte> random_layer(Random& random, const std::vector<ArrayShape>& shapes) {
  std::vector<std::byte> raw;
  for (const ArrayShape& shape : shapes) {
    const std::size_t begin = raw.size();
    raw.resize(begin + aligned(shape.size()));
    for (std::size_t i = 0; i < shape.size(); ++i) {
      raw[begin + i] = static_cast<std::byte>(random.below(256));
    }
  }
  return raw;
}

TEST(BytePlanes, AreTheDifferencesByteByByte) {
  // Two rows of two numbers of two bytes: 0x0102, 0x0304; then 0x0101, 0x0404.
  const std::vector<std::byte> array = {std::byte{2}, std::byte{1}, std::byte{4}, std::byte{3},
                                        std::byte{1}, std::byte{1}, std::byte{4}, std::byte{4}};
  std::vector<std::byte> planes;
  append_planes(array, {2, 2, 2}, planes);
  EXPECT_THAT(planes,
              testing::ElementsAre(std::byte{2}, std::byte{255}, std::byte{1}, std::byte{255},
                                   std::byte{4}, std::byte{0}, std::byte{3}, std::byte{1}));
}

TEST(PackedColumns, UnpackToTheSameBytes) {
  Random random(1);
  for (int i = 0; i < 300; ++i) {
    const std::uint64_t rows = 1 + random.below(40);
    const std::vector<ArrayShape> shapes = random_shapes(random, rows);
    const std::vector<std::byte> raw = random_layer(random, shapes);
    EXPECT_EQ(value_of(unpack_columns(pack_columns(raw, shapes), rows, raw.size())), raw);
  }
}

TEST(PackedColumns, DamageIsRefusedOrGivesALayerOfTheSameSize) {
  Random random(2);
  const std::vector<ArrayShape> shapes = {{30, 1, 4}, {30, 3, 8}, {30, 2, 1}};
  const std::vector<std::byte> raw = random_layer(random, shapes);
  const std::vector<std::byte> packed = pack_columns(raw, shapes);
  for (int i = 0; i < 20000; ++i) {
    std::vector<std::byte> damaged = packed;
    damaged[random.below(damaged.size())] ^= static_cast<std::byte>(1 + random.below(255));
    if (i % 4 == 0) damaged.resize(random.below(damaged.size()));
    const Result<std::vector<std::byte>> found = unpack_columns(damaged, 30, raw.size());
    if (found) {
      EXPECT_EQ(found->size(), raw.size());
    }
  }
  EXPECT_FALSE(unpack_columns(packed, 29, raw.size()));
  EXPECT_FALSE(unpack_columns(packed, 30, raw.size() - 64));
}

}  // namespace
}  // namespace sightline
