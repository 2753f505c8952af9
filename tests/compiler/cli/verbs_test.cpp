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

using ::testing::ElementsAre;
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

std::vector<std::string> words_of(const std::string& text) {
  std::vector<std::string> words;
  std::istringstream stream(text);
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

std::vector<std::string> joined(std::vector<std::string> first,
                                const std::vector<std::string>& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
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
        const Called called = find_called(program, words);
        ASSERT_NE(called.verb, nullptr) << example;
        EXPECT_TRUE(example.find("sightline " + called.verb->name) != std::string::npos)
            << example << " has an old name";
        shown.insert(called.verb->name);
        words.erase(words.begin(), words.begin() + static_cast<std::ptrdiff_t>(called.word_count));
        const Result<void> parsed = parse_words("sightline", *called.verb, words);
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
  EXPECT_EQ(cell->help, "For cells: edge of the cells of the grid");
}

TEST(Verbs, MeanTheSameByTheSameFlag) {
  // The help of these names the file, the tables or the facts of the verb.
  const std::set<std::string> with_own_help = {"--output", "--map",   "--json",   "--format",
                                               "--site",   "--fleet", "--tables", "--all"};
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
    if (verb.name == "delta apply" || !has("--output")) continue;
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
    const std::vector<std::string> name = words_of(verb.name);
    const std::string help = output_of(joined({"help"}, name));
    EXPECT_EQ(help, output_of(joined(name, {"--help"})));
    EXPECT_EQ(help, output_of(joined(name, {"-h", "--no-such-flag"}))) << "help comes first";
  }
  for (const Family& family : program.families) {
    EXPECT_EQ(output_of({"help", family.name}), output_of({family.name, "--help"}));
  }
}

TEST(Verbs, AreAtMost25AtTheTopAndStandInFamilies) {
  const Program program = sightline_program();
  EXPECT_LE(top_names(program).size(), 25U);
  EXPECT_THAT(names_in(program, "cluster"), ElementsAre("plan", "work", "link", "status"));
  EXPECT_THAT(names_in(program, "fleet"), ElementsAre("key", "root", "release", "sign", "admit"));
  EXPECT_THAT(names_in(program, "delta"), ElementsAre("make", "apply"));
  for (const Verb& verb : program.verbs) {
    const std::string family = family_of(verb);
    if (family.empty()) continue;
    EXPECT_NE(std::ranges::find(program.families, family, &Family::name), program.families.end())
        << verb.name;
  }
  const std::string help = help_text(program, program.families.front());
  EXPECT_THAT(help, HasSubstr("Usage: sightline cluster VERB [OPTION]..."));
  EXPECT_THAT(help, HasSubstr("\n  plan    Plan a compile"));
}

TEST(Verbs, AreFoundByTheirOldNamesWhichNoHelpShows) {
  const Program program = sightline_program();
  for (const auto& [alias, name] : program.aliases) {
    const Verb* const verb = find_verb(program, alias);
    ASSERT_NE(verb, nullptr) << alias;
    EXPECT_EQ(verb->name, name);
  }
  const std::string help = help_text(program);
  for (const char* old : {"\n  plan ", "\n  work ", "\n  apply ", "\n  admit ", "\n  key "}) {
    EXPECT_THAT(help, Not(HasSubstr(old)));
  }
}

TEST(FindCalled, TakesTwoWordsBeforeAnAliasOfOne) {
  const Program program = sightline_program();
  const auto called = [&](const std::vector<std::string>& words) {
    const Called found = find_called(program, words);
    return concat(found.verb == nullptr ? "" : found.verb->name, ":",
                  found.family == nullptr ? "" : found.family->name, ":", found.word_count);
  };
  EXPECT_EQ(called({"delta", "make", "a", "b"}), "delta make:delta:2");
  EXPECT_EQ(called({"delta", "a.slmap", "b.slmap"}), "delta make:delta:1") << "as before 0.1.0";
  EXPECT_EQ(called({"apply", "--help"}), "delta apply::1");
  EXPECT_EQ(called({"delta"}), ":delta:1");
  EXPECT_EQ(called({"cluster", "--help"}), ":cluster:1");
  EXPECT_EQ(called({"cluster", "make"}), ":cluster:1");
  EXPECT_EQ(called({"plan", "work"}), "cluster plan::1");
  EXPECT_EQ(called({"foo"}), "::0");
}

TEST(Verbs, AreQuietAndVerboseAndCountThreadsAlike) {
  for (const Verb& verb : sightline_program().verbs) {
    const auto flag = [&](const std::string& name) {
      return std::ranges::find(verb.flags, name, &long_name);
    };
    ASSERT_NE(flag("--quiet"), verb.flags.end()) << verb.name;
    ASSERT_NE(flag("--verbose"), verb.flags.end()) << verb.name;
    EXPECT_EQ(flag("--quiet")->names, "-q,--quiet");
    EXPECT_EQ(flag("--verbose")->names, "-v,--verbose");
    if (flag("--threads") == verb.flags.end()) continue;
    EXPECT_EQ(flag("--threads")->names, "-j,--threads") << verb.name;
  }
}

struct Slip {
  std::vector<std::string> words;
  std::string remedy;
};

TEST(Slips, AreAnsweredWithTheRemedy) {
  const std::vector<Slip> slips = {
      {{"foo"}, "unknown verb 'foo'; `sightline --help` lists them"},
      {{"gaet", "a.slmap"}, "unknown verb 'gaet'; did you mean 'gate'?"},
      {{"statsu"}, "unknown verb 'statsu'; did you mean 'cluster status'?"},
      {{"version"}, "write `sightline --version`"},
      {{"cluster", "paln"}, "unknown verb 'cluster paln'; did you mean 'plan'?"},
      {{"compile", "a.yaml", "b.yaml"}, "several drives are a list under mapping:"},
      {{"evaluate", "town.slmap"},
       "town.slmap is the map: write `sightline evaluate CONFIG --map town.slmap`"},
      {{"cache", "folder", "--json"}, "unknown flag --json; write --format json"},
      {{"cache", "folder", "-j", "4"}, "`sightline cache` uses one thread: leave the flag out"},
      {{"compile", "-c", "x.yaml"},
       "the configuration has no flag before it: `sightline compile FILE.yaml`"},
      {{"export", "a.slmap", "--format", "kml", "-o", "a.kml"}, "ogr2ogr"},
      {{"export", "a.slmap", "--format", "laz", "-o", "a.laz"}, "pdal translate"}};
  for (const Slip& slip : slips) {
    ::testing::internal::CaptureStderr();
    const int status = run_command_line(sightline_program(), slip.words);
    const std::string text = ::testing::internal::GetCapturedStderr();
    EXPECT_EQ(status, 64) << text;
    EXPECT_THAT(text, HasSubstr(slip.remedy));
  }
}

// Rewritten by tests/update_golden.sh.
TEST(Verbs, AreExplainedAsReviewed) {
  const std::string folder = std::string(SIGHTLINE_ROOT) + "/tests/golden/help/";
  for (const Verb& verb : sightline_program().verbs) {
    std::string file = verb.name + ".txt";
    std::ranges::replace(file, ' ', '-');
    const std::string reviewed = value_of(read_text_file(folder + file));
    EXPECT_EQ(help_of(verb), reviewed) << "tests/update_golden.sh rewrites " << verb.name;
  }
  const Program program = sightline_program();
  for (const Family& family : program.families) {
    EXPECT_EQ(help_text(program, family), value_of(read_text_file(folder + family.name + ".txt")));
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
