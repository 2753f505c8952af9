#include "formats/text/quoted_text.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(QuotedText, PutsFieldsInQuotesOnlyWhereTheyWouldBreakTheLine) {
  EXPECT_EQ(csv_field("a b"), "a b");
  EXPECT_EQ(csv_field("a,b"), "\"a,b\"");
  EXPECT_EQ(csv_field("a \"b\"\n"), "\"a \"\"b\"\"\n\"");
}

TEST(QuotedText, MakesXmlThatEveryReaderTakes) {
  EXPECT_EQ(xml_text("<a href=\"b\">&"), "&lt;a href=&quot;b&quot;&gt;&amp;");
  EXPECT_EQ(xml_text(std::string("a\0b\x1b[0m\tc\n", 10)), "ab[0m\tc\n");
}

TEST(QuotedText, MakesOneWordForAShell) {
  EXPECT_EQ(shell_word(""), "''");
  EXPECT_EQ(shell_word("a $b"), "'a $b'");
  EXPECT_EQ(shell_word("it's"), "'it'\\''s'");
}

}  // namespace
}  // namespace sightline
