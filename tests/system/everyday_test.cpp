#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <tuple>

#include "formats/base/files/atomic_file.h"
#include "tests/support/real_data.h"
#include "tests/support/value_of.h"
#include "tests/system/program.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::json;

constexpr const char* kQuick =
    " --set annotation.ranges_m=10,30 --set measure-error.offset_count=3 "
    "--set train-model.trees=20 -q";

std::string small_config() { return (small_town() / "town.yaml").string(); }

std::vector<Json> json_lines(const std::string& text) {
  std::vector<Json> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    const Json parsed = Json::parse(line, nullptr, /*allow_exceptions=*/false);
    EXPECT_TRUE(parsed.is_object()) << "no JSON object: " << line;
    if (parsed.is_object()) lines.push_back(parsed);
  }
  return lines;
}

void expect_progress(const std::vector<Json>& lines) {
  ASSERT_FALSE(lines.empty());
  std::size_t finished = 0;
  std::size_t reported = 0;
  std::size_t done = 0;
  for (const Json& line : lines) {
    const std::string event = line.at("event");
    if (event == "warning" || event == "information") continue;
    EXPECT_EQ(line.at("step"), finished + 1);
    if (event == "started") done = 0;
    if (event == "finished") {
      ++finished;
      EXPECT_GE(line.at("wall_s"), 0.0);
    }
    if (event != "progress") continue;
    ++reported;
    EXPECT_GE(line.at("done"), done);
    done = line.at("done");
    EXPECT_LE(done, line.at("total"));
    if (done == 0) continue;
    const double remaining_s = line.at("remaining_s");
    EXPECT_GE(remaining_s, 0.0);
    EXPECT_EQ(remaining_s == 0.0, done == line.at("total")) << line;
    EXPECT_GE(line.at("run_remaining_s"), remaining_s) << line;
  }
  EXPECT_EQ(lines.back().at("steps"), finished);
  EXPECT_GT(reported, 3U);
}

TEST(Everyday, TellsProgressAsJsonOnAnyDescriptor) {
  const fs::path folder = fresh_folder();
  const std::string compile =
      "compile " + small_config() + " --no-cache --stop-after build-surface ";
  const ProgramResult on_stderr = run_successfully(compile + "--json-progress");
  EXPECT_EQ(on_stderr.out, "");
  const std::vector<Json> lines = json_lines(on_stderr.err);
  ASSERT_FALSE(lines.empty());
  EXPECT_EQ(lines.back().at("pass"), "build-surface");

  const std::string file = (folder / "progress.jsonl").string();
  run_successfully("compile " + small_config() + " --no-cache -q -o " +
                   (folder / "town.slmap").string() + " --json-progress=5 5> " + file);
  expect_progress(json_lines(value_of(read_text_file(file))));

  const ProgramResult closed = run_sightline(compile + "--json-progress=77");
  EXPECT_EQ(closed.status, 64);
  EXPECT_THAT(closed.err, HasSubstr("77"));
}

TEST(Everyday, IsSilentOnAFileThatIsNoTerminal) {
  const ProgramResult run =
      run_successfully("compile " + small_config() + " --no-cache --stop-after build-ndt");
  EXPECT_THAT(run.err, Not(HasSubstr("\r"))) << "the moving line belongs on a terminal";
  EXPECT_THAT(run.err, Not(HasSubstr("\033[K")));
}

// What a verb cannot make any more it says, or it refuses the flag before anything is opened.
TEST(Everyday, StopAfterEndsEveryVerbThatRunsPasses) {
  const fs::path folder = fresh_folder();
  const std::string cache = " --cache " + (folder / "cache").string();
  const std::string stop = small_config() + cache + " --stop-after ingest";
  for (const auto& [verb, output, consequence] :
       {std::tuple{"compile ", "town.slmap", "no map is written"},
        std::tuple{"train ", "town.slmodel", "no model is written"}}) {
    const fs::path file = folder / output;
    const ProgramResult run = run_successfully(verb + stop + " -o " + file.string());
    EXPECT_THAT(run.err, HasSubstr(std::string("stopped after ingest: ") + consequence)) << verb;
    EXPECT_EQ(run.out, "") << verb;
    EXPECT_FALSE(fs::exists(file)) << verb;
  }
  for (const auto& [arguments, artifact] :
       {std::pair{"dump --what ranges ", "'ranges' is made later, by choose-ranges"},
        std::pair{"dump --what ranges --format svg ", "is made later"},
        std::pair{"export --format ply -o points.ply ", "'points' is made later, by remove"}}) {
    const ProgramResult run = run_sightline(arguments + stop);
    EXPECT_EQ(run.status, 64) << arguments << run.err;
    EXPECT_THAT(run.err, HasSubstr(std::string("--stop-after ingest: "))) << arguments;
    EXPECT_THAT(run.err, HasSubstr(artifact)) << arguments;
  }
  EXPECT_THAT(run_successfully("dump --what drive " + stop).out, HasSubstr("scan"));
}

TEST(Everyday, CompilesFromTheListedInputsAlone) {
  const ProgramResult listed = run_successfully("compile " + small_config() + " --list-inputs");
  const fs::path copy = fresh_folder();
  std::istringstream stream(listed.out);
  std::size_t count = 0;
  for (std::string file; std::getline(stream, file); ++count) {
    const fs::path target = copy / fs::path(file).lexically_relative(small_town());
    fs::create_directories(target.parent_path());
    fs::copy_file(file, target);
  }
  EXPECT_GT(count, 200U);
  EXPECT_FALSE(fs::exists(copy / "drive_2")) << "the evaluation drive takes no part in a compile";
  run_successfully("compile " + (copy / "town.yaml").string() + " -q -o " +
                   (copy / "town.slmap").string());
}

// Whether `ninja` had to compile. The map is remade only by the depfile's inputs.
bool ninja_compiles(const fs::path& folder) {
  const ProgramResult run = run_command("ninja -v -C " + folder.string());
  EXPECT_EQ(run.status, 0) << run.out << run.err;
  return run.out.find("no work to do") == std::string::npos;
}

TEST(Everyday, NinjaCompilesAgainWhenAnInputChangesAndOnlyThen) {
  const fs::path folder = fresh_folder() / "a town # of $5";
  fs::create_directories(folder);
  fs::copy(small_town() / "mapping", folder / "mapping", fs::copy_options::recursive);
  fs::copy(small_town() / "drive_1", folder / "drive_1", fs::copy_options::recursive);
  fs::copy_file(small_config(), folder / "town.yaml");
  ASSERT_TRUE(write_file_atomically(
      folder / "build.ninja",
      "rule map\n  command = " SIGHTLINE_PROGRAM
      " compile $in -o $out --force -q --stop-after build-ndt --depfile $out.d && touch $out\n"
      "  depfile = $out.d\n  deps = gcc\n"
      "build town.slmap: map town.yaml\n",
      IfExists::kRefuse));
  const auto compiles = [&] { return ninja_compiles("'" + folder.string() + "'"); };
  EXPECT_TRUE(compiles());
  EXPECT_FALSE(compiles()) << "nothing changed";
  for (const char* input : {"mapping/scans/000007.pcd", "drive_1/poses.tum", "town.yaml"}) {
    ASSERT_EQ(run_command("touch '" + (folder / input).string() + "'").status, 0);
    EXPECT_TRUE(compiles()) << input;
    EXPECT_FALSE(compiles()) << input;
  }
  fs::remove(folder / "drive_1" / "scans" / "000000.pcd");
  std::ofstream(folder / "mapping" / "unread.txt") << "no input";
  EXPECT_TRUE(run_command("ninja -n -C '" + folder.string() + "'").out.find("no work to do") ==
              std::string::npos)
      << "a scan that is gone changes the map";
}

TEST(Everyday, InitOfATownCompilesUnchanged) {
  const fs::path folder = fresh_folder();
  const std::string yaml = (folder / "drive.yaml").string();
  const ProgramResult drafted = run_successfully("init " + small_town().string() + " -o " + yaml);
  EXPECT_THAT(drafted.err, HasSubstr("evaluation: "));
  EXPECT_THAT(drafted.out, HasSubstr("Wrote " + yaml + " ("));
  EXPECT_THAT(drafted.out, HasSubstr("Next: sightline compile " + yaml));
  std::ifstream written(yaml);
  std::string first;
  std::getline(written, first);
  EXPECT_EQ(first, "# yaml-language-server: $schema=sightline.schema.json");
  const ProgramResult schema = run_successfully("passes --schema");
  std::ifstream beside(folder / "sightline.schema.json");
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(beside), {}), schema.out);
  const std::string map = (folder / "drive.slmap").string();
  run_successfully("compile " + yaml + " -o " + map + kQuick);
  run_successfully("verify " + map);
  run_successfully("evaluate " + yaml + " --map " + map + kQuick);
  const ProgramResult again = run_sightline("init " + small_town().string() + " -o " + yaml);
  EXPECT_EQ(again.status, 64) << "a configuration that may be edited is not overwritten";
}

TEST(EverydayRealDrive, InitOfARealDriveCompilesUnchanged) {
  const RealData data = real_data("kitti_0005");
  if (!data.missing.empty()) GTEST_SKIP() << data.missing;
  const fs::path folder = fresh_folder();
  const std::string yaml = (folder / "drive.yaml").string();
  const ProgramResult drafted = run_successfully("init " + data.folder.string() + " -o " + yaml);
  EXPECT_THAT(drafted.err, HasSubstr("hdl-64e"));
  run_successfully("compile " + yaml + " -q -o " + (folder / "drive.slmap").string());
}

}  // namespace
}  // namespace sightline
