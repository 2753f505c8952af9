#include "compiler/cli/quoted_place.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "compiler/cli/command_line.h"
#include "compiler/commands/commands.h"
#include "tests/support/scratch_folder.h"

namespace sightline {
namespace {

using ::testing::HasSubstr;

class QuotedPlace : public TestInFolder {
 protected:
  [[nodiscard]] std::string quote(const std::string& text, const std::string& place) const {
    const std::filesystem::path file = folder_ / "a.yaml";
    std::ofstream(file, std::ios::binary) << text;
    return quoted_place({ErrorCode::kBadValue, "", file.string(), place});
  }
  std::string complaint(const std::string& text) {
    const std::filesystem::path file = folder_ / "a.yaml";
    std::ofstream(file, std::ios::binary) << text;
    ::testing::internal::CaptureStderr();
    EXPECT_NE(run_command_line(sightline_program(), {"compile", file.string(), "-o", "b.slmap"}),
              0);
    return ::testing::internal::GetCapturedStderr();
  }
};

TEST_F(QuotedPlace, HasACaretBelowTheColumn) {
  EXPECT_EQ(quote("a: 1\n  cell_m: -1\n", "line 2, column 11"),
            "      cell_m: -1\n"
            "              ^\n");
  EXPECT_EQ(quote("größe: -1\r\n", "line 1, column 10"), "    größe: -1\n           ^\n")
      << "characters of two bytes are one column";
  EXPECT_EQ(quote("\tb: \x1b[31m\n", "line 1, column 2"), "     b: \\x1b[31m\n     ^\n");
}

TEST_F(QuotedPlace, IsEmptyWithoutAPlaceThatCanBeShown) {
  EXPECT_EQ(quote("a: 1\n", "line 1"), "");
  EXPECT_EQ(quote("a: 1\n", "byte 3"), "");
  EXPECT_EQ(quote("a: 1\n", "line 2, column 1"), "");
  EXPECT_EQ(quote("a: 1\n", "line 1, column 90"), "");
  EXPECT_EQ(quote("a: 1\n\n", "line 2, column 1"), "");
  EXPECT_EQ(quoted_place({ErrorCode::kBadValue, "", "no/such/file", "line 1, column 1"}), "");
}

TEST_F(QuotedPlace, FollowsErrorsOfConfigurations) {
  EXPECT_THAT(complaint("mapping: {scan: velodyne}\n"),
              HasSubstr("did you mean 'scans'?\n    mapping: {scan: velodyne}\n" +
                        std::string(14, ' ') + "^\n"));
  EXPECT_THAT(complaint("mapping: {scans: \"velodyne}\n"),
              HasSubstr("this quote is not closed\n    mapping: {scans: \"velodyne}\n" +
                        std::string(21, ' ') + "^\n"));
  EXPECT_THAT(complaint("mapping: {scans: a}\ngate: {unmet-share: 0.1}\n"),
              HasSubstr("belongs under gate.rules"));
}

TEST(MissingFile, IsExplained) {
  const auto complaint = [](const std::string& file) {
    ::testing::internal::CaptureStderr();
    EXPECT_NE(run_command_line(sightline_program(), {"compile", file, "-o", "b.slmap"}), 0);
    return ::testing::internal::GetCapturedStderr();
  };
  EXPECT_THAT(complaint("-"), HasSubstr("a configuration is a file"));
  EXPECT_THAT(complaint("https://example.com/a.yaml"), HasSubstr("URLs are not read"));
  EXPECT_THAT(complaint("~/no_such_folder/a.yaml"), HasSubstr("are not expanded here"));
}

}  // namespace
}  // namespace sightline
