#include "compiler/views/report/page/packed.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/compiler/views/report/unpacked.h"

namespace sightline {
namespace {

template <class T>
void expect_back(const std::vector<T>& values, const std::string& type) {
  const PageJson json = json_numbers(values);
  EXPECT_EQ(json.at("type"), type);
  EXPECT_EQ(unpacked<T>(json), values);
}

TEST(Packed, AnyArrayReadsBackExactly) {
  std::mt19937_64 random(7);
  for (std::size_t count = 0; count < 300; count = 2 * count + 1) {
    std::vector<std::uint8_t> bytes;
    std::vector<std::uint16_t> shorts;
    std::vector<std::uint32_t> words;
    std::vector<float> floats;
    std::vector<double> doubles;
    for (std::size_t i = 0; i < count; ++i) {
      bytes.push_back(static_cast<std::uint8_t>(random()));
      shorts.push_back(static_cast<std::uint16_t>(random()));
      words.push_back(static_cast<std::uint32_t>(random()));
      doubles.push_back(static_cast<double>(random()) / 3.0);
      floats.push_back(static_cast<float>(doubles.back()));
    }
    expect_back(bytes, "u8");
    expect_back(shorts, "u16");
    expect_back(words, "u32");
    expect_back(floats, "f32");
    expect_back(doubles, "f64");
  }
}

TEST(Packed, FourDigitsAreKeptAndNoMore) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> exponent(-12.0, 12.0);
  for (int i = 0; i < 10000; ++i) {
    const double value = (i % 2 == 0 ? 1.0 : -1.0) * std::pow(10.0, exponent(random));
    EXPECT_NEAR(four_digits(value), value, std::abs(value) / 16384.0);
  }
  EXPECT_EQ(four_digits(0.0), 0.0F);
  EXPECT_EQ(four_digits(0.5), 0.5F);
  EXPECT_TRUE(std::isinf(four_digits(std::numeric_limits<double>::infinity())));
}

}  // namespace
}  // namespace sightline
