#include "compiler/views/text/size_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

namespace sightline {
namespace {

using testing::HasSubstr;

MapSummary summary() {
  MapSummary summary;
  summary.file_size = 1000;
  summary.manifest_size = 100;
  summary.directory_size = 50;
  summary.blocks = {{.name = "column.speed", .stored_size = 30},
                    {.name = "error-model", .stored_size = 200},
                    {.name = "factors", .stored_size = 100},
                    {.name = "ndt", .stored_size = 400}};
  return summary;
}

// Rows as `name bytes share`; names may have two words.
std::vector<std::pair<std::string, double>> rows_of(const std::string& table) {
  std::vector<std::pair<std::string, double>> rows;
  std::istringstream lines(table);
  std::string line;
  std::getline(lines, line);
  std::getline(lines, line);
  while (std::getline(lines, line) && line.front() != '`') {
    rows.emplace_back(line.substr(0, line.find("  ")), std::stod(line.substr(28)));
  }
  return rows;
}

TEST(SizeTable, AddsUpToTheFileLargestPartFirst) {
  const auto rows = rows_of(size_table(summary(), 0.0));
  ASSERT_EQ(rows.size(), 7u);
  EXPECT_EQ(rows.front(), std::pair(std::string("ndt"), 400.0));
  double sum = 0.0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    sum += rows[i].second;
    if (i > 0) {
      EXPECT_LE(rows[i].second, rows[i - 1].second);
    }
  }
  EXPECT_EQ(sum, 1000.0);
}

TEST(SizeTable, CountsBytesByKilometreAndNamesWhatIsLost) {
  const std::string table = size_table(summary(), 500.0);
  EXPECT_THAT(table, HasSubstr("1000 bytes, 2000 for each km of 0.500 km of route\n"));
  EXPECT_EQ(rows_of(table).front(), std::pair(std::string("ndt"), 800.0));
  EXPECT_THAT(table, HasSubstr("40.0 %  cannot be matched with"));
  EXPECT_THAT(table, HasSubstr("3.0 %  lacks this figure at each place"));
  EXPECT_THAT(table, HasSubstr("leaves out model and factors: about 1400 bytes/km remain.\n"));
}

TEST(SizeTable, SaysNothingOfStripWhereThatLeavesOutNothing) {
  MapSummary stripped = summary();
  stripped.blocks = {{.name = "ndt", .stored_size = 400}};
  EXPECT_EQ(size_table(stripped, 500.0).find("strip"), std::string::npos);
}

}  // namespace
}  // namespace sightline
