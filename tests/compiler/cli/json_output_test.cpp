#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "compiler/cli/command_line.h"
#include "compiler/commands/commands.h"
#include "formats/base/files/atomic_file.h"
#include "tests/support/json_schema.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

// What verbs print with --format json keeps to its schema.

namespace sightline {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Json = nlohmann::json;

class JsonOutput : public TestInFolder {
 protected:
  static std::string output_of(const std::vector<std::string>& words) {
    ::testing::internal::CaptureStdout();
    const int status = run_command_line(sightline_program(), words);
    const std::string text = ::testing::internal::GetCapturedStdout();
    EXPECT_EQ(status, 0) << ::testing::PrintToString(words);
    return text;
  }
  static Json schema(const std::string& name) {
    const std::string file = std::string(SIGHTLINE_ROOT) + "/schemas/" + name + ".schema.json";
    return Json::parse(value_of(read_text_file(file), file));
  }
  // An empty one.
  std::string cache() {
    const std::filesystem::path folder = folder_ / "cache";
    std::filesystem::create_directories(folder);
    return folder.string();
  }
};

TEST_F(JsonOutput, OfPassesKeepsToItsSchema) {
  const Json passes = Json::parse(output_of({"passes", "--format", "json"}));
  EXPECT_EQ(schema_faults(schema("passes"), passes), "");
  EXPECT_EQ(passes.front()["pass"], "ingest");
  EXPECT_FALSE(passes.front()["output"].get<std::string>().empty());
}

TEST_F(JsonOutput, OfACacheKeepsToItsSchema) {
  const Json plain = Json::parse(output_of({"cache", cache(), "--format", "json"}));
  EXPECT_EQ(schema_faults(schema("cache"), plain), "");
  EXPECT_EQ(plain["objects"], 0);
  EXPECT_FALSE(plain.contains("unused_days"));
  Json aged = Json::parse(output_of({"cache", cache(), "--format", "json", "--unused-days", "30"}));
  EXPECT_EQ(schema_faults(schema("cache"), aged), "");
  EXPECT_EQ(aged["unused_days"], 30);
  aged["objects"] = -1;
  EXPECT_NE(schema_faults(schema("cache"), aged), "");
}

TEST_F(JsonOutput, OfEveryTableOfAMapKeepsToItsSchema) {
  const std::string map = (folder_ / "a.slmap").string();
  std::filesystem::copy_file(
      std::filesystem::path(SIGHTLINE_ROOT) / "tests/fuzz/corpus/map/seed_plain", map);
  for (const char* what : {"sites", "ranges", "nds"}) {
    const Json table = Json::parse(output_of({"dump", map, "--what", what, "--format", "json"}));
    EXPECT_EQ(schema_faults(schema("dump"), table), "") << what;
    for (const Json& row : table["rows"]) ASSERT_EQ(row.size(), table["columns"].size());
  }
}

TEST_F(JsonOutput, GoesToAFileWhoseEndingNamesTheFormat) {
  const std::string file = (folder_ / "passes.json").string();
  EXPECT_THAT(output_of({"passes", "-o", file}), HasSubstr("Wrote " + file));
  EXPECT_EQ(schema_faults(schema("passes"), Json::parse(value_of(read_text_file(file)))), "");
  EXPECT_THAT(output_of({"passes", "-o", file, "--force", "-q"}), IsEmpty());
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(run_command_line(sightline_program(), {"passes", "-o", file}), 64) << "no --force";
  EXPECT_THAT(::testing::internal::GetCapturedStderr(), HasSubstr("--force"));
}

TEST_F(JsonOutput, OfAVerboseCommandIsFollowedByItsCostOnStderr) {
  ::testing::internal::CaptureStderr();
  output_of({"cache", cache(), "-v"});
  EXPECT_THAT(::testing::internal::GetCapturedStderr(), HasSubstr("sightline cache took 0."));
}

}  // namespace
}  // namespace sightline
