#include "compiler/cli/console/written.h"

#include <gtest/gtest.h>
#include <filesystem>
#include <fstream>

namespace sightline {
namespace {

TEST(SizeText, HasThreeDigitsAndADecimalUnit) {
  EXPECT_EQ(size_text(812), "812 bytes");
  EXPECT_EQ(size_text(14'200), "14.2 kB");
  EXPECT_EQ(size_text(1'430'000), "1.43 MB");
  EXPECT_EQ(size_text(2'100'000'000), "2.10 GB");
}

TEST(WrittenLine, NamesPathSizeAndContent) {
  const std::filesystem::path file =
      std::filesystem::path(testing::TempDir()) / "written_line_test.txt";
  std::ofstream(file) << "12345";
  EXPECT_EQ(written_line(file), "Wrote " + file.string() + " (5 bytes)\n");
  EXPECT_EQ(written_line(file, "3 places"), "Wrote " + file.string() + " (5 bytes): 3 places\n");
  std::filesystem::remove(file);
}

TEST(WrittenLine, AddsNothingToDataOnADevice) {
  EXPECT_EQ(written_line("/dev/null"), "");
  EXPECT_EQ(written_line("/dev/stdout/no_such_file"), "");
}

}  // namespace
}  // namespace sightline
