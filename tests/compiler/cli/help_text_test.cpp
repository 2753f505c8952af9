#include "compiler/cli/help_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "compiler/cli/common_flags.h"

namespace sightline {
namespace {

TEST(HelpText, ShowsWhatFollowsFromTheDescription) {
  std::string wall;
  std::string picture;
  std::string color = "white";
  int coats = 2;
  int site = -1;
  bool is_forced = false;
  Verb verb;
  verb.name = "paint";
  verb.summary = "Paint a wall";
  verb.details = "First\nline.\n\nSecond paragraph.";
  verb.examples = {"house paint north"};
  verb.positionals = {{.name = "WALL", .help = "The wall", .target = &wall}};
  verb.flags = {required_output_flag(picture, "The picture"),
                {.names = "--color",
                 .value = "COLOR",
                 .help = "The color",
                 .target = &color,
                 .choices = {"white", "green"}},
                {.names = "--coats",
                 .value = "N",
                 .help = "How many",
                 .target = &coats,
                 .minimum = 1,
                 .maximum = 9},
                {.names = "--site", .value = "N", .help = "One", .target = &site, .minimum = 0},
                {.names = "--secret", .help = "Nobody sees it", .is_hidden = true},
                force_flag(is_forced)};
  EXPECT_EQ(help_text("house paint", verb),
            "Usage: house paint [OPTION]... --output FILE WALL\n\n"
            "Paint a wall\n\n"
            "Arguments:\n"
            "  WALL  The wall\n\n"
            "Options:\n"
            "  -o, --output FILE  The picture (required)\n"
            "      --color COLOR  The color (one of white, green; default: white)\n"
            "      --coats N      How many (a whole number from 1 to 9; default: 2)\n"
            "      --site N       One\n"
            "      --force        Replace outputs that exist\n"
            "  -h, --help         Print this help\n\n"
            "First line.\n\n"
            "Second paragraph.\n\n"
            "Examples:\n"
            "  house paint north\n");
}

TEST(HelpText, BreaksLinesAtTheSecondColumn) {
  Verb verb;
  std::string words;
  for (int i = 0; i < 40; ++i) words += "word ";
  verb.flags = {{.names = "--force", .help = words}};
  const std::string text = help_text("house", verb);
  EXPECT_THAT(text, ::testing::HasSubstr("word\n               word"));
  std::size_t longest = 0;
  std::size_t begin = 0;
  for (std::size_t end = 0; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1) {
    longest = std::max(longest, end - begin);
  }
  EXPECT_LE(longest, kHelpColumns);
  EXPECT_GT(longest, kHelpColumns - 5);
}

}  // namespace
}  // namespace sightline
