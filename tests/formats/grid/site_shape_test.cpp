#include "formats/grid/site_shape.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(SiteShape, CountsTheLastIndexFastest) {
  const SiteShape shape{3, 2};
  std::size_t expected = 0;
  for (std::size_t site = 0; site < 5; ++site) {
    EXPECT_EQ(shape.size(site), expected);
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t column = 0; column < 2; ++column) {
        ASSERT_EQ(shape.index(site, row, column), expected);
        EXPECT_EQ(shape.site_of(expected), site);
        EXPECT_EQ(shape.row_of(expected), row);
        EXPECT_EQ(shape.column_of(expected), column);
        ++expected;
      }
    }
  }
}

TEST(SiteShape, HasOneColumnWhereNobodyNamesMore) {
  const SiteShape shape{4};
  EXPECT_EQ(shape.index(2, 3), 11U);
  EXPECT_EQ(shape.size(3), 12U);
  EXPECT_EQ(shape.row_of(11), 3U);
}

}  // namespace
}  // namespace sightline
