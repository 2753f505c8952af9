#include "compiler/config/config_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <filesystem>

#include "formats/base/files/atomic_file.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

struct Values {
  double cell_m = 2.0;
  std::string scans;
  std::vector<double> ranges_m = {10.0, 20.0};
  bool enabled = true;
  std::vector<Look> looks;
};

class ConfigFile : public ::testing::Test {
 protected:
  std::vector<ConfigSection> sections() {
    return {
        {"build-ndt", "cells", {number("cell_m", values_.cell_m, "edge, m", 0.1, 100.0)}},
        {"mapping", "drive", {text("scans", values_.scans, "folder")}},
        {"annotation",
         "shared",
         {numbers("ranges_m", values_.ranges_m, "ranges, m", 1.0, 300.0),
          flag("enabled", values_.enabled, "whether"), looks("looks", values_.looks, "looks")}}};
  }
  Result<void> read(const std::string& yaml) {
    file_ = scratch_folder() / "config_file_test.yaml";
    EXPECT_TRUE(write_file_atomically(file_, yaml, IfExists::kReplace));
    std::vector<ConfigSection> all = sections();
    return read_yaml(file_, all);
  }
  Values values_;
  std::filesystem::path file_;
};

TEST_F(ConfigFile, SetsWhatItNamesAndLeavesTheRest) {
  require(
      read("mapping: {scans: 'drive one/scans'}\n"
           "annotation:\n  ranges_m: [10, 15]\n  enabled: false\n"));
  EXPECT_EQ(values_.scans, "drive one/scans");
  EXPECT_EQ(values_.ranges_m, (std::vector<double>{10.0, 15.0}));
  EXPECT_FALSE(values_.enabled);
  EXPECT_EQ(values_.cell_m, 2.0);
}

struct BadConfig {
  std::string yaml;
  ErrorCode code;
  std::string place;
  std::string hint;
};

TEST_F(ConfigFile, SaysLineAndNearestNameOfWhatItCannotRead) {
  const std::vector<BadConfig> cases = {
      {"build-ndt:\n  cel_m: 1.0\n", ErrorCode::kUnknownKey, "line 2", "did you mean 'cell_m'?"},
      {"\nbuild_ndt:\n  cell_m: 1.0\n", ErrorCode::kUnknownKey, "line 2",
       "did you mean 'build-ndt'?"},
      {"build-ndt:\n  colour: red\n", ErrorCode::kUnknownKey, "line 2", "known keys: cell_m"},
      {"build-ndt:\n  cell_m: two\n", ErrorCode::kBadValue, "line 2", "found 'two'"},
      {"build-ndt:\n  cell_m: {a: 1}\n", ErrorCode::kBadValue, "line 2", "found a map"},
      {"annotation:\n  ranges_m: [[1]]\n", ErrorCode::kBadValue, "line 2", "nested"},
      {"build-ndt: 3\n", ErrorCode::kBadValue, "line 1", "map of keys"},
      {"- a\n- b\n", ErrorCode::kMalformedText, "line 1", "map of sections"},
      {"build-ndt:\n  cell_m: [1\n", ErrorCode::kMalformedText, "line 3", "not YAML"},
      {"build-ndt:\n  cell_m: 1\n  cell_m: 2\n", ErrorCode::kMalformedText, "line 3",
       "a second 'cell_m'; the first one is in line 2"},
      {"build-ndt:\n  cell_m: 1\nmapping:\n  scans: a\nbuild-ndt:\n", ErrorCode::kMalformedText,
       "line 5", "a second 'build-ndt'"},
      {"mapping: {scans: a}\n---\nmapping: {scans: b}\n", ErrorCode::kMalformedText, "line 3",
       "a second document"}};
  for (const BadConfig& bad : cases) {
    const Error refused = failure_of(read(bad.yaml), bad.yaml);
    EXPECT_EQ(refused.code, bad.code) << bad.yaml;
    EXPECT_EQ(refused.place.substr(0, refused.place.find(',')), bad.place) << bad.yaml;
    EXPECT_EQ(refused.file, file_.string());
    EXPECT_NE(refused.message.find(bad.hint), std::string::npos) << refused.message;
  }
}

TEST_F(ConfigFile, ReadsBackItsOwnYaml) {
  values_ = {1.25, "a: \"b\"", {12.5, 100.0}, false, {}};
  const std::string yaml = to_yaml(sections());
  values_ = {};
  values_.looks = *parse_looks("50 m, 2000 returns, 80 points");
  require(read(yaml));
  EXPECT_EQ(values_.cell_m, 1.25);
  EXPECT_EQ(values_.scans, "a: \"b\"");
  EXPECT_EQ(values_.ranges_m, (std::vector<double>{12.5, 100.0}));
  EXPECT_FALSE(values_.enabled);
  EXPECT_TRUE(values_.looks.empty());  // "paper"
}

TEST_F(ConfigFile, WritesWhatIsNoUtf8AsAReplacement) {
  values_.scans = "a\xff";
  EXPECT_NE(to_yaml(sections()).find("scans: \"a\xEF\xBF\xBD\""), std::string::npos);
}

TEST_F(ConfigFile, TakesSingleOverrides) {
  std::vector<ConfigSection> all = sections();
  EXPECT_TRUE(set_override("build-ndt.cell_m=0.5", all));
  EXPECT_EQ(values_.cell_m, 0.5);
  EXPECT_TRUE(set_override("mapping.scans=/a.b/c=d", all));
  EXPECT_EQ(values_.scans, "/a.b/c=d");
  EXPECT_EQ(set_override("cell_m", all).error().code, ErrorCode::kBadArgument);
  EXPECT_EQ(set_override("cell_m=3", all).error().code, ErrorCode::kBadArgument);
  EXPECT_EQ(set_override("build-ndt.cell=3", all).error().code, ErrorCode::kUnknownKey);
  EXPECT_EQ(set_override("build-ndt.cell_m=-3", all).error().code, ErrorCode::kBadValue);
}

using testing::ElementsAre;
using testing::IsEmpty;

TEST(PlaceNames, BeginBelowTheFolderThatHoldsAll) {
  EXPECT_THAT(place_names({"/data/north/town.yaml", "/data/south/town.yaml"}),
              ElementsAre("north/town.yaml", "south/town.yaml"));
  EXPECT_THAT(place_names({"/data/town.yaml", "/data/south/town.yaml"}),
              ElementsAre("town.yaml", "south/town.yaml"));
  EXPECT_THAT(place_names({"/data/north.yaml", "/date/south.yaml"}),
              ElementsAre("data/north.yaml", "date/south.yaml"));
  EXPECT_THAT(place_names({"/data/town.yaml"}), ElementsAre("town.yaml"));
  EXPECT_THAT(place_names({}), IsEmpty());
}

TEST(PlaceNames, DependNeitherOnWhereThatFolderLiesNorOnHowItIsWritten) {
  const std::vector<std::string> here = place_names({"north.yaml", "old/./town.yaml"});
  EXPECT_THAT(here, ElementsAre("north.yaml", "old/town.yaml"));
  EXPECT_EQ(place_names({"/a/b/c/north.yaml", "/a/b/../b/c/old/town.yaml"}), here);
}

}  // namespace
}  // namespace sightline
