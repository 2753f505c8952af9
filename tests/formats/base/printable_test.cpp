#include "formats/base/printable.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(Printable, LeavesPlainTextAndOtherScriptsAlone) {
  const std::string text = "Zürich 東京 \U0001F697\n\tkm/h ~ ' \"";
  EXPECT_EQ(printable(text), text);
  EXPECT_EQ(printable(""), "");
}

TEST(Printable, EscapesWhatSteersATerminal) {
  EXPECT_EQ(printable("a\x1b[2Jb"), "a\\x1b[2Jb");
  EXPECT_EQ(printable("\r\a\b\x7f"), "\\x0d\\x07\\x08\\x7f");
  EXPECT_EQ(printable("\xc2\x9b"
                      "31m"),
            "\\xc2\\x9b31m")
      << "a control character of C1";
  EXPECT_EQ(printable("map\xe2\x80\xaepamls."), "map\\xe2\\x80\\xaepamls.") << "turned around";
  EXPECT_EQ(printable(std::string_view("\0", 1)), "\\x00");
}

TEST(Printable, EscapesWhatIsNoUtf8) {
  EXPECT_EQ(printable("\xff"), "\\xff");
  EXPECT_EQ(printable("\x9b"), "\\x9b");
  EXPECT_EQ(printable("a\xc3"), "a\\xc3") << "cut short";
  EXPECT_EQ(printable("\xc0\x9b"), "\\xc0\\x9b") << "longer than needed";
  EXPECT_EQ(printable("\xed\xa0\x80"), "\\xed\\xa0\\x80") << "half of a pair";
}

TEST(Printable, LeavesNoControlCharacterOfAnyTwoBytes) {
  for (int a = 0; a < 256; ++a) {
    for (int b = 0; b < 256; ++b) {
      const std::string text = {static_cast<char>(a), static_cast<char>(b)};
      for (const char c : printable(text)) {
        const bool is_control = static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t';
        EXPECT_FALSE(is_control || c == 0x7f) << a << ' ' << b;
      }
    }
  }
}

}  // namespace
}  // namespace sightline
