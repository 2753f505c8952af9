#include "compiler/cli/command_line.h"
#include "tests/support/value_of.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sightline {
namespace {

using ::testing::ElementsAre;

struct PaintFlags {
  std::string wall;
  std::vector<std::string> tools;
  std::string output;
  std::string color = "white";
  int coats = 1;
  double width_m = 0.5;
  std::uint64_t counter = 0;
  std::vector<std::string> pairs;
  std::vector<std::string> forms = {"text"};
  int descriptor = 0;
  bool is_forced = false;
  bool is_quiet = false;
  bool is_verbose = false;
  std::string set_text;
};

Verb paint_verb(PaintFlags& flags) {
  Verb verb;
  verb.name = "paint";
  verb.positionals = {
      {.name = "WALL", .help = "The wall", .target = &flags.wall},
      {.name = "TOOL", .help = "What to paint with", .target = &flags.tools, .is_required = false}};
  verb.flags = {
      {.names = "-o,--output", .value = "FILE", .help = "The picture", .target = &flags.output},
      {.names = "--color",
       .value = "COLOR",
       .target = &flags.color,
       .choices = {"white", "green", "blue"}},
      {.names = "--coats", .value = "N", .target = &flags.coats, .minimum = 1, .maximum = 9},
      {.names = "--width-m", .value = "METRES", .target = &flags.width_m, .minimum = 0.0},
      {.names = "--counter", .value = "N", .target = &flags.counter},
      {.names = "--pair", .value = "FILE FILE", .target = &flags.pairs},
      {.names = "--format", .value = "F", .target = &flags.forms, .choices = {"text", "json"}},
      {.names = "--progress", .value = "N", .target = &flags.descriptor, .bare_value = "2"},
      {.names = "--force", .target = &flags.is_forced},
      {.names = "-q,--quiet", .target = &flags.is_quiet},
      {.names = "-v,--verbose", .target = &flags.is_verbose, .excludes = "--quiet"},
      {.names = "--set",
       .value = "TEXT",
       .target = Setter([&flags](const std::string& text) -> Result<void> {
         if (text == "bad") return Error{ErrorCode::kBadValue, "found 'bad'"};
         flags.set_text = flags.color + text;
         return {};
       })}};
  return verb;
}

Result<void> parse(const std::vector<std::string>& words, PaintFlags& flags) {
  return parse_words("house paint", paint_verb(flags), words);
}

std::string error_of(const std::vector<std::string>& words) {
  PaintFlags flags;
  return outcome_of(parse(words, flags));
}

TEST(ParseWords, SetsEveryKindOfTarget) {
  PaintFlags flags;
  require(parse({"north", "--coats=3", "-qo", "out.png", "--width-m", "0.25", "brush", "--counter",
                 "18446744073709551615", "--pair", "a", "b", "roller", "--force"},
                flags));
  EXPECT_EQ(flags.wall, "north");
  EXPECT_THAT(flags.tools, ElementsAre("brush", "roller"));
  EXPECT_EQ(flags.output, "out.png");
  EXPECT_EQ(flags.color, "white") << "the default stays";
  EXPECT_EQ(flags.coats, 3);
  EXPECT_EQ(flags.width_m, 0.25);
  EXPECT_EQ(flags.counter, 18446744073709551615U);
  EXPECT_THAT(flags.pairs, ElementsAre("a", "b"));
  EXPECT_THAT(flags.forms, ElementsAre("text"));
  EXPECT_TRUE(flags.is_forced);
  EXPECT_TRUE(flags.is_quiet);
  EXPECT_FALSE(flags.is_verbose);
}

TEST(ParseWords, TakesOneValueEachTimeAListIsNamedAndForgetsItsDefault) {
  PaintFlags flags;
  ASSERT_TRUE(parse({"--format", "json", "north", "--format=text"}, flags));
  EXPECT_THAT(flags.forms, ElementsAre("json", "text"));
  EXPECT_EQ(flags.wall, "north");
}

TEST(ParseWords, CallsSettersAfterAllElseIsSet) {
  PaintFlags flags;
  ASSERT_TRUE(parse({"north", "--set", "wash", "--color", "green"}, flags));
  EXPECT_EQ(flags.set_text, "greenwash");
}

TEST(ParseWords, TakesAValueThatMayBeLeftOutOnlyBehindAnEqualsSign) {
  PaintFlags bare;
  ASSERT_TRUE(parse({"--progress", "5"}, bare));
  EXPECT_EQ(bare.descriptor, 2);
  EXPECT_EQ(bare.wall, "5");
  PaintFlags given;
  ASSERT_TRUE(parse({"north", "--progress=5"}, given));
  EXPECT_EQ(given.descriptor, 5);
}

TEST(ParseWords, TakesWordsBehindTwoHyphensAsTheyAre) {
  PaintFlags flags;
  ASSERT_TRUE(parse({"--", "--force"}, flags));
  EXPECT_EQ(flags.wall, "--force");
  EXPECT_FALSE(flags.is_forced);
  EXPECT_FALSE(asks_for_help({"--", "--help"}));
  EXPECT_TRUE(asks_for_help({"north", "-h"}));
}

struct Refusal {
  std::vector<std::string> words;
  std::string message;
};

TEST(ParseWords, RefusesWithACodeAndTheNearestName) {
  const std::vector<Refusal> refusals = {
      {{"north", "--outptu", "a"},
       "SL1001 bad-argument: unknown flag --outptu; did you mean '--output'?"},
      {{"north", "--zzzzzzzzz"},
       "SL1001 bad-argument: unknown flag --zzzzzzzzz; `house paint --help` lists them"},
      {{"north", "-x"}, "SL1001 bad-argument: unknown flag -x; `house paint --help` lists them"},
      {{}, "SL1001 bad-argument: WALL is required: The wall"},
      {{"north", "-o"}, "SL1001 bad-argument: --output needs a value: FILE"},
      {{"north", "--pair", "a"}, "SL1001 bad-argument: --pair needs a value: FILE FILE"},
      {{"north", "-o", "--force"},
       "SL1001 bad-argument: --output needs a value: FILE; found the flag --force"},
      {{"north", "--force=yes"}, "SL1001 bad-argument: --force takes no value"},
      {{"north", "-o", "a", "--output=b"},
       "SL1001 bad-argument: --output is given 2 times, as 'a' and 'b'; it takes one value"},
      {{"north", "-q", "-v"}, "SL1001 bad-argument: --verbose and --quiet cannot be used together"},
      {{"north", "--coats", "two"},
       "SL1003 bad-value: --coats: found 'two', expected a whole number from 1 to 9"},
      {{"north", "--coats", "2.5"},
       "SL1003 bad-value: --coats: found '2.5', expected a whole number from 1 to 9"},
      {{"north", "--coats", "10"},
       "SL1003 bad-value: --coats: found '10', expected a whole number from 1 to 9"},
      {{"north", "--coats", "99999999999999999999"},
       "SL1003 bad-value: --coats: found '99999999999999999999', expected a whole number from 1 "
       "to 9"},
      {{"north", "--counter", "-1"},
       "SL1003 bad-value: --counter: found '-1', expected a whole number"},
      {{"north", "--width-m", "-0.1"},
       "SL1003 bad-value: --width-m: found '-0.1', expected a number of at least 0"},
      {{"north", "--width-m", "nan"},
       "SL1003 bad-value: --width-m: found 'nan', expected a number of at least 0"},
      {{"north", "--set", "bad"}, "SL1003 bad-value: --set: found 'bad'"},
      {{"north", "--color", "gren"},
       "SL1007 unknown-name: --color: 'gren' is not known; did you mean 'green'?"},
      {{"north", "--color", "mauve-ish"},
       "SL1007 unknown-name: --color: 'mauve-ish' is not known; it is one of white, green, blue"}};
  for (const Refusal& refusal : refusals) EXPECT_EQ(error_of(refusal.words), refusal.message);
}

TEST(ParseWords, RefusesAnotherEndingAndNamesTheRemedyOfAValue) {
  std::string file;
  std::string format;
  Verb verb;
  verb.flags = {{.names = "--output",
                 .value = "FILE",
                 .target = &file,
                 .remedies = {{".pdf", "print the page"}},
                 .endings = {".html"}},
                {.names = "--format",
                 .value = "F",
                 .target = &format,
                 .choices = {"gpkg"},
                 .remedies = {{"kml", "is not written; convert it"}}}};
  const auto error = [&](const std::vector<std::string>& words) {
    return outcome_of(parse_words("house paint", verb, words));
  };
  EXPECT_EQ(error({"--output", "a.txt"}),
            "SL1001 bad-argument: --output: found 'a.txt', expected a path that ends in .html");
  EXPECT_EQ(error({"--output", "a.pdf"}),
            "SL1001 bad-argument: --output: found 'a.pdf', expected a path that ends in .html; "
            "print the page");
  EXPECT_EQ(error({"--format", "kml"}),
            "SL1007 unknown-name: --format: 'kml' is not written; convert it");
  for (const char* fine : {"a.html", "folder.d/a", "/dev/stdout"}) {
    require(parse_words("house paint", verb, {"--output", fine}));
  }
}

TEST(ParseWords, RefusesAWordTooMany) {
  PaintFlags flags;
  Verb verb = paint_verb(flags);
  verb.positionals.pop_back();
  EXPECT_EQ(to_string(failure_of(parse_words("house paint", verb, {"north", "south"}))),
            "SL1001 bad-argument: unexpected word 'south'; `house paint --help` shows the "
            "usage");
}

}  // namespace
}  // namespace sightline
