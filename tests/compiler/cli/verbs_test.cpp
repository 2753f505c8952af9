#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <map>
#include <set>
#include <sstream>
#include <vector>

#include "compiler/cli/command_line.h"
#include "compiler/cli/common_flags.h"
#include "compiler/cli/help_text.h"
#include "compiler/cli/verb.h"
#include "compiler/commands/commands.h"
#include "formats/base/files/atomic_file.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::Not;

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::string output_of(const std::vector<std::string>& words) {
  ::testing::internal::CaptureStdout();
  const int status = run_command_line(sightline_program(), words);
  const std::string text = ::testing::internal::GetCapturedStdout();
  EXPECT_EQ(status, 0) << ::testing::PrintToString(words);
  return text;
}

std::string help_of(const Verb& verb) { return help_text("sightline " + verb.name, verb); }

// The commands of an example: of "sightline a && sightline b > c # d" the words behind "sightline".
std::vector<std::vector<std::string>> commands_in(const std::string& example) {
  const std::set<std::string> ends = {"|", "||", "&&", ">", ">>", "#"};
  std::vector<std::vector<std::string>> commands;
  bool is_command = false;
  std::istringstream words(example);
  for (std::string word; words >> word;) {
    if (word == "sightline" || word == "<(sightline") {
      commands.emplace_back();
      is_command = true;
    } else if (ends.contains(word)) {
      is_command = false;
    } else if (is_command && word != "\\") {
      commands.back().push_back(word.ends_with(')') ? word.substr(0, word.size() - 1) : word);
    }
  }
  return commands;
}

TEST(Verbs, ShowExamplesThatCanBeParsed) {
  for (const Verb& verb : sightline_program().verbs) {
    std::set<std::string> shown;
    for (const std::string& example : verb.examples) {
      for (std::vector<std::string> words : commands_in(example)) {
        const Program program = sightline_program();
        const Verb* const called = find_verb(program, words.front());
        ASSERT_NE(called, nullptr) << example;
        shown.insert(words.front());
        words.erase(words.begin());
        const Result<void> parsed = parse_words("sightline", *called, words);
        EXPECT_TRUE(parsed.has_value()) << example << ": " << to_string(parsed.error());
      }
    }
    EXPECT_TRUE(shown.contains(verb.name)) << verb.name << " has no example of its own";
  }
}

TEST(Verbs, ExplainTheEdgeOfACellByTheGrid) {
  const Verb verb = *find_verb(sightline_program(), "export");
  const auto cell = std::ranges::find(verb.flags, "--cell", &Flag::names);
  ASSERT_NE(cell, verb.flags.end());
  EXPECT_EQ(cell->help, "Of cells: the edge of a cell of the grid");
}

TEST(Verbs, MeanTheSameByTheSameFlag) {
  // Where a file is named, the help says which; it may differ.
  const std::set<std::string> with_own_help = {"--output", "--map",  "--json",
                                               "--format", "--site", "--fleet"};
  // Who makes a map names a LiDAR, a vehicle that admits one names the digest of its own.
  const std::string of_two_meanings = "--sensor";
  std::map<std::string, Flag> known;
  for (const Verb& verb : sightline_program().verbs) {
    for (const Flag& flag : verb.flags) {
      if (long_name(flag) == of_two_meanings) continue;
      const auto [first, is_new] = known.emplace(long_name(flag), flag);
      if (is_new) continue;
      EXPECT_EQ(flag.names, first->second.names) << verb.name;
      EXPECT_EQ(flag.value, first->second.value) << verb.name << " " << flag.names;
      if (with_own_help.contains(long_name(flag))) continue;
      EXPECT_EQ(flag.help.substr(0, 12), first->second.help.substr(0, 12)) << verb.name;
    }
  }
  std::map<std::string, std::string> letters;
  for (const auto& [name, flag] : known) {
    if (names_of(flag).size() == 1) continue;
    EXPECT_TRUE(letters.emplace(names_of(flag).front(), name).second)
        << names_of(flag).front() << " is short for two flags";
  }
}

TEST(Verbs, CanReplaceWhatTheyWrite) {
  for (const Verb& verb : sightline_program().verbs) {
    const auto has = [&](const std::string& name) {
      return std::ranges::find(verb.flags, name, &long_name) != verb.flags.end();
    };
    EXPECT_FALSE(has("--out")) << verb.name << ": the flag is called --output";
    // apply promises a map that was not there before.
    if (verb.name == "apply" || !has("--output")) continue;
    EXPECT_TRUE(has("--force")) << verb.name;
  }
}

TEST(Verbs, AreDescribedInOneLineOfOurOwnWords) {
  const Program program = sightline_program();
  std::vector<std::string> texts = {help_text(program)};
  for (const Verb& verb : program.verbs) {
    EXPECT_FALSE(verb.summary.ends_with('.')) << verb.name;
    for (const Flag& flag : shown_flags(verb)) {
      EXPECT_FALSE(flag.help.empty() || flag.help.ends_with('.')) << verb.name << flag.names;
    }
    texts.push_back(help_of(verb));
  }
  for (const std::string& text : texts) {
    for (const std::string& line : lines_of(text)) EXPECT_LE(line.size(), kHelpColumns) << line;
    for (const char* word : {"INT", "TEXT:", "FLOAT", "UINT", "REQUIRED", "Excludes", "Positionals",
                             "SUBCOMMAND", " ..."}) {
      EXPECT_THAT(text, Not(HasSubstr(word)));
    }
  }
  for (const std::string& line : lines_of(help_text(program))) {
    EXPECT_FALSE(line.starts_with("    ") && line.find("--") == std::string::npos)
        << "a summary is longer than one line: " << line;
  }
}

TEST(Verbs, AreExplainedByHelpAsByTheirFlag) {
  const Program program = sightline_program();
  EXPECT_EQ(output_of({"help"}), output_of({"--help"}));
  for (const Verb& verb : program.verbs) {
    const std::string help = output_of({"help", verb.name});
    EXPECT_EQ(help, output_of({verb.name, "--help"}));
    EXPECT_EQ(help, output_of({verb.name, "-h", "--no-such-flag"})) << "help comes first";
  }
}

// Rewritten by tests/update_golden.sh.
TEST(Verbs, AreExplainedAsReviewed) {
  const std::string folder = std::string(SIGHTLINE_ROOT) + "/tests/golden/help/";
  for (const Verb& verb : sightline_program().verbs) {
    const std::string reviewed = value_of(read_text_file(folder + verb.name + ".txt"));
    EXPECT_EQ(help_of(verb), reviewed) << "tests/update_golden.sh rewrites " << verb.name;
  }
}

TEST(Verbs, ReportAWrongTableWithTheNearestName) {
  const Program program = sightline_program();
  const Error parsed = failure_of(
      parse_words("sightline dump", *find_verb(program, "dump"), {"a.slmap", "--what", "nd"}));
  EXPECT_EQ(to_string(parsed),
            "SL1007 unknown-name: --what: 'nd' is not known; did you mean 'nds'?");
  EXPECT_EQ(exit_status(parsed.code), 64);
}

// A compile makes no such artifact.
TEST(Verbs, TakeWhatAMapAloneHas) {
  const Program program = sightline_program();
  require(
      parse_words("sightline dump", *find_verb(program, "dump"), {"a.slmap", "--what", "columns"}));
}

TEST(BuildDetails, TellCommitFormatsKernelsAndLibrariesLineByLine) {
  const std::vector<std::string> lines = lines_of(build_details());
  ASSERT_EQ(lines.size(), 6u) << build_details();
  EXPECT_THAT(lines[0], MatchesRegex("commit         ([0-9a-f]+|unknown)"));
  EXPECT_EQ(lines[1], "map format     1.0");
  EXPECT_THAT(lines[2], MatchesRegex("model format   [0-9]+"));
  EXPECT_THAT(lines[3], MatchesRegex("configuration  schema [0-9a-f]+"));
  EXPECT_THAT(lines[4], HasSubstr("portable"));
  for (const char* library : {"Ceres ", "Eigen ", "Embree ", "OpenSSL ", "bzip2 ", "zstd "}) {
    EXPECT_THAT(lines[5], HasSubstr(library));
  }
}

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
  EXPECT_THAT(text, HasSubstr("word\n               word"));
  std::size_t longest = 0;
  for (const std::string& line : lines_of(text)) longest = std::max(longest, line.size());
  EXPECT_LE(longest, kHelpColumns);
  EXPECT_GT(longest, kHelpColumns - 5);
}

}  // namespace
}  // namespace sightline
