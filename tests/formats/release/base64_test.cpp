#include "formats/release/base64.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

std::string of_text(std::string_view text) { return base64_of(std::as_bytes(std::span(text))); }

TEST(Base64, WritesTheExamplesOfRfc4648) {
  EXPECT_EQ(of_text(""), "");
  EXPECT_EQ(of_text("f"), "Zg==");
  EXPECT_EQ(of_text("fo"), "Zm8=");
  EXPECT_EQ(of_text("foo"), "Zm9v");
  EXPECT_EQ(of_text("foobar"), "Zm9vYmFy");
}

TEST(Base64, ReadsTheOneTextThatItWritesAndNoOther) {
  const std::optional<std::vector<std::uint8_t>> bytes = bytes_of_base64("Zm8=", 2);
  ASSERT_TRUE(bytes);
  EXPECT_EQ(*bytes, (std::vector<std::uint8_t>{'f', 'o'}));
  for (const char* text : {"", "Zm8", "Zm9=", "Zm8= ", "Zm-=", "Zm9v"}) {
    EXPECT_FALSE(bytes_of_base64(text, 2)) << text;
  }
}

}  // namespace
}  // namespace sightline
