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

std::vector<std::byte> sealed(std::string_view content) {
  std::vector<std::byte> object = bytes_of(content);
  const std::vector<std::byte> seal = seal_of(kName, object);
  object.insert(object.end(), seal.begin(), seal.end());
  return object;
}

TEST(SealedObject, SaysWhatItIsAndHoldsWhatWasSealed) {
  for (const std::string_view content : {"", "x", "some content"}) {
    const std::vector<std::byte> object = sealed(content);
    const Result<SealedObject> opened = open_object(object);
    ASSERT_TRUE(opened);
    EXPECT_EQ(opened->name, kName);
    EXPECT_EQ(std::vector(opened->content.begin(), opened->content.end()), bytes_of(content));
  }
}

TEST(SealedObject, IsRefusedCutShortAtEveryByte) {
  const std::vector<std::byte> object = sealed("some content");
  for (std::size_t size = 0; size < object.size(); ++size) {
    EXPECT_FALSE(open_object(std::span(object).first(size))) << size;
    EXPECT_FALSE(open_object(std::span(object).subspan(size + 1))) << size;
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
