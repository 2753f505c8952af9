#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "tests/system/program.h"

namespace sightline {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::IsSupersetOf;
using ::testing::Not;

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> words_of(const std::string& text) {
  std::vector<std::string> words;
  std::istringstream stream(text);
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

std::string help_of(const std::string& verb) { return run_successfully(verb + " --help").out; }

std::vector<std::string> verbs() {
  std::vector<std::string> names;
  for (const std::string& line : lines_of(help_of(""))) {
    const std::string name = words_of(line).empty() ? "" : words_of(line).front();
    if (line.starts_with("  " + name + "  ") && !name.starts_with('-')) names.push_back(name);
  }
  return names;
}

// With the verbs of families: "cluster plan".
std::vector<std::string> all_verbs() {
  std::vector<std::string> names;
  for (const std::string& name : verbs()) {
    bool is_family = false;
    for (const std::string& line : lines_of(help_of(name))) {
      if (line == "Options:") break;
      is_family |= line == "Verbs:";
      if (!is_family || !line.starts_with("  ")) continue;
      names.push_back(name + " " + words_of(line).front());
    }
    if (!is_family) names.push_back(name);
  }
  return names;
}

TEST(CommandLine, TeachesWhereToBeginWithoutArguments) {
  const ProgramResult run = run_sightline("");
  EXPECT_EQ(run.status, 64);
  EXPECT_EQ(run.out, "");
  for (const char* text : {"sightline init", "sightline compile", "verify", "--help"}) {
    EXPECT_THAT(run.err, HasSubstr(text));
  }
}

TEST(CommandLine, NamesTheNearestVerbAndFlag) {
  const ProgramResult verb = run_sightline("complie town.yaml");
  EXPECT_EQ(verb.status, 64);
  EXPECT_THAT(verb.err, HasSubstr("SL1001"));
  EXPECT_THAT(verb.err, HasSubstr("did you mean 'compile'?"));
  const ProgramResult flag = run_sightline("compile town.yaml -o town.slmap --forse");
  EXPECT_EQ(flag.status, 64);
  EXPECT_THAT(flag.err, HasSubstr("did you mean '--force'?"));
  for (const char* family : {"cluster", "fleet", "delta"}) {
    const ProgramResult alone = run_sightline(family);
    EXPECT_EQ(alone.status, 64);
    EXPECT_THAT(alone.err, HasSubstr(std::string("Usage: sightline ") + family + " VERB"));
    EXPECT_EQ(run_successfully(std::string(family) + " --help").out, alone.err);
  }
  const ProgramResult strange = run_sightline("qqqqqqqqqq");
  EXPECT_EQ(strange.status, 64);
  EXPECT_THAT(strange.err, HasSubstr("--help"));
}

std::string on_a_terminal(const std::string& environment, const std::string& arguments) {
  const ProgramResult run =
      run_command("env -u NO_COLOR TERM=xterm " + environment +
                  " script -qec '" SIGHTLINE_PROGRAM " " + arguments + "' /dev/null");
  EXPECT_THAT(run.out, HasSubstr("SL1001"));
  return run.out;
}

TEST(CommandLine, IsColouredOnATerminalAloneAndNeverUnderNoColor) {
  if (run_command("command -v script").status != 0) GTEST_SKIP() << "script is not installed";
  EXPECT_THAT(on_a_terminal("", "complie"), HasSubstr("\033["));
  EXPECT_THAT(on_a_terminal("NO_COLOR=", "complie"), HasSubstr("\033[")) << "empty is not set";
  EXPECT_THAT(on_a_terminal("NO_COLOR=1", "complie"), Not(HasSubstr("\033[")));
  EXPECT_THAT(run_sightline("complie").err, Not(HasSubstr("\033[")));
}

std::vector<std::string> bash_offers(const std::string& typed) {
  std::vector<std::string> words = words_of(typed);
  if (typed.ends_with(' ')) words.emplace_back("''");
  std::string list;
  for (const std::string& word : words) list += " " + word;
  const std::filesystem::path script = fresh_folder() / "ask.bash";
  std::ofstream(script) << "set -eu\nsource <(" << SIGHTLINE_PROGRAM << " completion bash)\n"
                        << "complete -p sightline > /dev/null\nCOMP_WORDS=(" << list << ")\n"
                        << "COMP_CWORD=$((${#COMP_WORDS[@]} - 1))\n_sightline\n"
                        << "printf '%s\\n' \"${COMPREPLY[@]}\"\n";
  const ProgramResult run = run_command("bash " + script.string());
  EXPECT_EQ(run.status, 0) << run.err;
  return words_of(run.out);
}

TEST(Completion, OffersVerbsFlagsAndValuesInBash) {
  EXPECT_THAT(bash_offers("sightline comp"), ElementsAre("compile", "completion"));
  EXPECT_THAT(bash_offers("sightline "), ::testing::ElementsAreArray(verbs()));
  EXPECT_THAT(bash_offers("sightline compile drive.yaml --thr"), ElementsAre("--threads"));
  EXPECT_THAT(bash_offers("sightline compile -"), IsSupersetOf({"-o", "--output", "--force"}));
  EXPECT_THAT(bash_offers("sightline dump a.slmap --what ra"),
              ElementsAre("ranges", "ranges-looks"));
  EXPECT_THAT(bash_offers("sightline completion "), ElementsAre("bash", "zsh", "fish"));
  EXPECT_THAT(bash_offers("sightline cluster "), ElementsAre("plan", "work", "link", "status"));
  EXPECT_THAT(bash_offers("sightline cluster work --sta"), ElementsAre("--stage"));
  EXPECT_THAT(bash_offers("sightline work --sta"), ElementsAre("--stage")) << "the old name";
  EXPECT_THAT(bash_offers("sightline compile a.yaml --set build-ndt.ce"),
              ElementsAre("build-ndt.cell_m="));
  EXPECT_THAT(bash_offers("sightline evaluate a.yaml --set annotation.see"),
              ElementsAre("annotation.seed="));
  EXPECT_THAT(bash_offers("sightline compile -o "), IsEmpty()) << "files are left to readline";
  EXPECT_THAT(bash_offers("sightline nonsense "), IsEmpty());
}

TEST(Completion, OffersEveryFlagOfEveryVerbInBash) {
  for (const std::string& verb : all_verbs()) {
    const std::vector<std::string> offered = bash_offers("sightline " + verb + " -");
    for (const std::string& line : lines_of(help_of(verb))) {
      if (!line.starts_with("  -") && !line.starts_with("      --")) continue;
      for (const std::string& word : words_of(line.substr(0, line.find("  ", 6)))) {
        const std::string flag = word.substr(0, word.find_first_of(",[="));
        if (!flag.starts_with('-')) continue;
        EXPECT_THAT(offered, ::testing::Contains(flag)) << verb;
      }
    }
  }
}

TEST(Completion, OffersVerbsAndFlagsInZsh) {
  if (run_command("command -v zsh").status != 0) GTEST_SKIP() << "zsh is not installed";
  const std::filesystem::path folder = fresh_folder();
  const std::string file = (folder / "_sightline").string();
  ASSERT_EQ(run_sightline("completion zsh > " + file).status, 0);
  const ProgramResult parsed = run_command("zsh -n " + file);
  EXPECT_EQ(parsed.status, 0) << parsed.err;
  // A real zsh on a terminal of its own, asked with the tab key.
  std::ofstream(folder / "ask.zsh") << R"(
zmodload zsh/zpty
zpty shell "TERM=dumb zsh -f -i"
say() { zpty -w shell "$1"; }
# Reads until the marker comes, at most ten seconds.
await() { zpty -r -m shell reply "*$1*" 2> /dev/null || true; print -r -- "$reply"; }
say "PS1=; PS2=; autoload -Uz compinit; compinit -u -D; unsetopt zle_bracketed_paste; source $1; echo rea'dy'"
await ready > /dev/null
say "bindkey '^I' complete-word; zstyle ':completion:*' menu no; LISTMAX=0; echo se't'"
await set > /dev/null
zpty -w -n shell $'sightline verif\t\C-a: \C-e\n'
say "echo don'e'1"
await done1
zpty -w -n shell $'sightline compile --thr\t\C-a: \C-e\n'
say "echo don'e'2"
await done2
zpty -w -n shell $'sightline cluster sta\t\C-a: \C-e\n'
say "echo don'e'3"
await done3
zpty -w -n shell $'sightline cluster work --sha\t\C-a: \C-e\n'
say "echo don'e'4"
await done4
zpty -w -n shell $'sightline compile --set build-ndt.ce\t\C-a: \C-e\n'
say "echo don'e'5"
await done5
zpty -d shell
)";
  const ProgramResult run =
      run_command("timeout 20 zsh -f " + (folder / "ask.zsh").string() + " " + file);
  for (const char* offered :
       {"verify", "--threads", "cluster status", "--share", "build-ndt.cell_m="}) {
    EXPECT_THAT(run.out, HasSubstr(offered));
  }
}

std::vector<std::string> fish_offers(const std::string& script, const std::string& typed) {
  const ProgramResult run =
      run_command("fish --no-config -c 'source " + script + "; complete -C \"" + typed + "\"'");
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(run.err, "");
  std::vector<std::string> offered;
  for (const std::string& line : lines_of(run.out)) {
    offered.push_back(line.substr(0, line.find('\t')));
  }
  return offered;
}

TEST(Completion, OffersVerbsFlagsAndKeysInFish) {
  if (run_command("command -v fish").status != 0) GTEST_SKIP() << "fish is not installed";
  const std::string script = (fresh_folder() / "sightline.fish").string();
  ASSERT_EQ(run_sightline("completion fish > " + script).status, 0);
  EXPECT_THAT(fish_offers(script, "sightline comp"), ElementsAre("compile", "completion"));
  EXPECT_THAT(fish_offers(script, "sightline "), IsSupersetOf(verbs()));
  EXPECT_THAT(fish_offers(script, "sightline cluster "),
              ElementsAre("link", "plan", "status", "work"));
  EXPECT_THAT(fish_offers(script, "sightline cluster work --sha"), ElementsAre("--share"));
  EXPECT_THAT(fish_offers(script, "sightline compile a.yaml --set build-ndt.ce"),
              ElementsAre("build-ndt.cell_m="));
  EXPECT_THAT(fish_offers(script, "sightline dump a.slmap --what ranges"),
              ElementsAre("ranges", "ranges-looks"));
  EXPECT_THAT(fish_offers(script, "sightline completion "), ElementsAre("bash", "fish", "zsh"));
}

TEST(ManPage, IsSetWithoutWarningsAndTellsOfEveryVerbAndFailure) {
  if (run_command("command -v man").status != 0) GTEST_SKIP() << "man is not installed";
  const std::string file = (fresh_folder() / "sightline.1").string();
  ASSERT_EQ(run_sightline("man > " + file).status, 0);
  const ProgramResult page = run_command(
      "LC_ALL=C.UTF-8 MANWIDTH=100 man --warnings=all --no-hyphenation -l " + file + " | col -b");
  EXPECT_EQ(page.err, "");
  std::string text;  // as one line
  for (const std::string& word : words_of(page.out)) text += word + " ";
  for (const std::string& verb : all_verbs()) {
    EXPECT_THAT(text, HasSubstr("sightline " + verb + " ")) << "no usage of " << verb;
  }
  for (const char* part :
       {"EXIT STATUS", "--threads N", "sightline compile town.yaml -o town.slmap",
        "SL2006 truncated-scan", " 69 gate"}) {
    EXPECT_THAT(text, HasSubstr(part));
  }
}

TEST(CommandLine, ExportAlongLanesAsksForTheLanes) {
  const ProgramResult run =
      run_sightline("export no_such.slmap --format lanelet2 -o no_such_folder/lanes.osm");
  EXPECT_EQ(run.status, 64);
  EXPECT_THAT(run.err, HasSubstr("--lanes lanelet2_map.osm"));
}

}  // namespace
}  // namespace sightline
