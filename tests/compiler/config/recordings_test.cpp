#include "compiler/config/recordings.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "compiler/driver/configuration.h"
#include "compiler/driver/pipelines.h"
#include "formats/base/files/atomic_file.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

Result<CompileConfig> load(const std::string& yaml,
                           const std::vector<std::string>& overrides = {}) {
  const fs::path file = scratch_folder() / "recordings_test" / "drive.yaml";
  EXPECT_TRUE(write_file_atomically(file, yaml, IfExists::kReplace));
  return load_compile_config(file, overrides);
}

std::vector<std::string> steps_of(const CompilePlan& compile) {
  std::vector<std::string> names;
  for (const PassStep& step : compile.plan.steps()) names.push_back(step.name);
  return names;
}

void touch(const fs::path& file) {
  fs::create_directories(file.parent_path());
  EXPECT_TRUE(write_file_atomically(file, "", IfExists::kReplace)) << file;
}

fs::path drives_of_a_week() {
  const fs::path folder = scratch_folder() / "recordings_test" / "week";
  fs::remove_all(folder);
  for (const char* day : {"day_10", "day_9"}) {
    for (const char* scan : {"0.pcd", "1.pcd"}) touch(folder / day / "scans" / scan);
    touch(folder / day / "poses.tum");
  }
  return folder;
}

TEST(Recordings, TakesAFolderOfRecordings) {
  const fs::path folder = drives_of_a_week();
  const CompileConfig config =
      value_of(load("mapping: {recordings: week, sensor: vlp-16, poses: poses.tum}\n"));
  EXPECT_EQ(config.mapping.scans, (folder / "day_9/scans").string()) << "9 comes before 10";
  EXPECT_EQ(config.mapping.name, "day_9/scans");
  EXPECT_EQ(config.mapping.poses, (folder / "day_9/poses.tum").string());
  ASSERT_EQ(config.later_mapping.size(), 1U);
  EXPECT_EQ(config.later_mapping[0].scans, (folder / "day_10/scans").string());
  EXPECT_EQ(config.later_mapping[0].poses, (folder / "day_10/poses.tum").string());
  EXPECT_EQ(config.later_mapping[0].sensor, "vlp-16");
  const CompileConfig list =
      value_of(load("mapping: [{scans: week/day_9/scans}, {scans: week/day_10/scans}]\n"));
  EXPECT_EQ(steps_of(compile_plan(config)), steps_of(compile_plan(list)));
}

TEST(Recordings, TakesAFileThatListsRecordings) {
  const fs::path folder = drives_of_a_week();
  ASSERT_TRUE(write_file_atomically(folder / "list.txt",
                                    "# by day\n\nday_10/scans\r\nday_9/scans\tday_10/poses.tum\n",
                                    IfExists::kReplace));
  const CompileConfig config =
      value_of(load("mapping: {scans: a}\nlocalization: {recordings: week/list.txt}\n"));
  EXPECT_FALSE(config.is_split());
  EXPECT_EQ(config.localization.scans, (folder / "day_10/scans").string()) << "as it is listed";
  EXPECT_EQ(config.localization.poses, "");
  ASSERT_EQ(config.later_localization.size(), 1U);
  EXPECT_EQ(config.later_localization[0].poses, (folder / "day_10/poses.tum").string());
  const CompileConfig named = value_of(
      load("mapping: {scans: a}\n", {"localization.recordings=" + (folder / "list.txt").string()}));
  EXPECT_EQ(named.later_localization.size(), 1U);
}

TEST(Recordings, RefusesWhatIsNone) {
  const fs::path folder = drives_of_a_week();
  fs::create_directories(folder / "empty");
  touch(folder / "none.txt");
  ASSERT_TRUE(write_file_atomically(folder / "long.txt", "a\tb\tc\n", IfExists::kReplace));
  const auto refused = [](const std::string& text, ErrorCode code, const std::string& says) {
    const Error config = failure_of(load(text), text);
    EXPECT_EQ(config.code, code) << to_string(config);
    EXPECT_NE(to_string(config).find(says), std::string::npos) << to_string(config);
  };
  refused("mapping: {recordings: week, scans: a}\n", ErrorCode::kBadValue,
          "mapping.recordings: found scans or a name beside it");
  refused("mapping: [{recordings: week}, {scans: a}]\n", ErrorCode::kBadValue,
          "found a list of drives beside it");
  refused("mapping: {recordings: month}\n", ErrorCode::kFileNotFound, "recordings_test/month");
  refused("mapping: {recordings: week/empty}\n", ErrorCode::kEmptyDirectory,
          "mapping.recordings: found no recording in this folder");
  refused("mapping: {recordings: week/none.txt}\n", ErrorCode::kMalformedText, "the list is empty");
  refused("mapping: {recordings: week/long.txt}\n", ErrorCode::kMalformedText, "line 1");
  refused("mapping: {recordings: week, poses: track.tum}\n", ErrorCode::kFileNotFound,
          "found no file 'track.tum' in or beside this folder of scans");
  refused("mapping: {scans: a}\nlocalization: {recordings: week, stamps: t.txt}\n",
          ErrorCode::kFileNotFound, "localization.recordings: found no file 't.txt'");
}

}  // namespace
}  // namespace sightline
