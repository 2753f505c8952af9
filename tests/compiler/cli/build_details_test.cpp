#include "compiler/commands/commands.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>
#include <vector>

namespace sightline {
namespace {

using ::testing::HasSubstr;
using ::testing::MatchesRegex;

TEST(BuildDetails, TellCommitFormatsKernelsAndLibrariesLineByLine) {
  std::istringstream text(build_details());
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(line);
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

}  // namespace
}  // namespace sightline
