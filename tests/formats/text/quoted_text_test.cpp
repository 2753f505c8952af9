#include "formats/text/quoted_text.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(QuotedText, PutsFieldsInQuotesOnlyWhereTheyWouldBreakTheLine) {
  EXPECT_EQ(csv_field("a b"), "a b");
  EXPECT_EQ(csv_field("a,b"), "\"a,b\"");
  EXPECT_EQ(csv_field("a \"b\""), "\"a \"\"b\"\"\"");
}

TEST(QuotedText, MakesFieldsOfOneLineThatAreNoFormulas) {
  EXPECT_EQ(csv_field("a\n::error::b\r"), "a\\x0a::error::b\\x0d");
  EXPECT_EQ(csv_field("\xff"), "\\xff");
  EXPECT_EQ(csv_field("=cmd|'/c calc'!A1"), "'=cmd|'/c calc'!A1");
  for (const char* formula : {"@SUM(A1)", "+1+cmd", "-2*A1", "=1,2"}) {
    EXPECT_NE(csv_field(formula).find('\''), std::string::npos) << formula;
  }
  for (const char* number : {"-1.5", "+2", "-1e-05", "-inf", "-nan", "-", "+", ""}) {
    EXPECT_EQ(csv_field(number), number);
  }
}

TEST(QuotedText, MakesMarkdownWithoutSyntax) {
  EXPECT_EQ(markdown_text("a|b `c` *d* _e_ [f](g)\n<script>@all"),
            "a\\|b \\`c\\` \\*d\\* \\_e\\_ \\[f\\](g)\\\\x0a&lt;script>&#64;all");
  EXPECT_EQ(markdown_code("a`b\n"), "a'b\\x0a");
}

TEST(QuotedText, MakesOneCommandOfGithub) {
  EXPECT_EQ(github_message("100 %\n::error::a: b, c"), "100 %25%0A::error::a: b, c");
  EXPECT_EQ(github_property("a:b,c\n%\x1b"), "a%3Ab%2Cc%0A%25\\x1b");
}

TEST(QuotedText, MakesScalarsThatYamlReadsBack) {
  for (const char* plain : {"velodyne/", "a-b_c.d", "-1.5", "12"}) {
    EXPECT_EQ(yaml_scalar(plain), plain);
  }
  EXPECT_EQ(yaml_scalar("a\nsensor: x"), "\"a\\x0asensor: x\"");
  EXPECT_EQ(yaml_scalar("- \"a\\"), "\"- \\\"a\\\\\"");
  EXPECT_EQ(yaml_scalar("東京"), "\"東京\"");
  EXPECT_EQ(yaml_scalar(""), "\"\"");
  EXPECT_EQ(yaml_scalar("a\u202e\u2028\u0085"), "\"a\\u202e\\u2028\\u0085\"");
  EXPECT_EQ(yaml_scalar("::x ##[y]"), "\"::x \\u0023#[y]\"");
}

TEST(QuotedText, MakesXmlThatEveryReaderTakes) {
  EXPECT_EQ(xml_text("<a href=\"b\">&"), "&lt;a href=&quot;b&quot;&gt;&amp;");
  EXPECT_EQ(xml_text(std::string("a\0b\x1b[0m\tc\n", 10)), "a\\x00b\\x1b[0m\tc\n");
}

TEST(QuotedText, MakesOneWordForAShell) {
  EXPECT_EQ(shell_word(""), "''");
  EXPECT_EQ(shell_word("a $b"), "'a $b'");
  EXPECT_EQ(shell_word("it's"), "'it'\\''s'");
}

}  // namespace
}  // namespace sightline
