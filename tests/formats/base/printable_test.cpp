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

TEST(Printable, EscapesOtherLineEndsAndMarksOfDirection) {
  EXPECT_EQ(printable("a\u2028b\u2029"), "a\\xe2\\x80\\xa8b\\xe2\\x80\\xa9");
  EXPECT_EQ(printable("\u061c\u200e\u200f"), "\\xd8\\x9c\\xe2\\x80\\x8e\\xe2\\x80\\x8f");
  EXPECT_EQ(printable("\u2013 \u2026"), "\u2013 \u2026");
}

TEST(OneLine, EscapesWhatWouldBeginALine) {
  EXPECT_EQ(one_line("a\n::error::b\tc"), "a\\x0a::error::b\\x09c");
  EXPECT_EQ(one_line("Zürich 東京"), "Zürich 東京");
}

TEST(OneLine, IsNoCommandOfContinuousIntegration) {
  EXPECT_EQ(one_line("::error title=x::y ##[error]z"), "\\x3a:error title=x::y \\x23#[error]z");
  EXPECT_EQ(one_line("a::b #[c]"), "a::b #[c]");
}

TEST(LogText, HasNoCommandsOfContinuousIntegration) {
  EXPECT_EQ(log_text("::error file=a::b"), "\\x3a:error file=a::b");
  EXPECT_EQ(log_text("a\n  ::set-output name=x::y\n"), "a\n  \\x3a:set-output name=x::y\n");
  EXPECT_EQ(log_text("a ##[error]b"), "a \\x23#[error]b");
  EXPECT_EQ(log_text("std::vector :: a\n:b\n\x1b"), "std::vector :: a\n:b\n\\x1b");
  EXPECT_EQ(log_text("\n\n::a"), "\n\n\\x3a:a");
}

TEST(PrintableJson, EscapesInTheWayOfJson) {
  EXPECT_EQ(printable_json("{\n \"a\": \"東\u202e\u2028\u0085\x7f\"\n}"),
            "{\n \"a\": \"東\\u202e\\u2028\\u0085\\u007f\"\n}");
  EXPECT_EQ(printable_json("{\"a\": 1}"), "{\"a\": 1}");
}

TEST(Utf8Text, ReplacesWhatIsNone) {
  EXPECT_EQ(utf8_text("a\xff"
                      "b\xc3"),
            "a\ufffdb\ufffd");
  EXPECT_EQ(utf8_text("Zürich"), "Zürich");
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
