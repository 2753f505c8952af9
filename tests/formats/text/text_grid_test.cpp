#include "formats/text/text_grid.h"
#include "formats/text/numbers.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(TextGrid, PutsColumnsUnderEachOther) {
  EXPECT_EQ(aligned({{"range (m)", "10", "15"}, {"error", "3.25"}}),
            "range (m)    10  15\nerror      3.25\n");
  EXPECT_EQ(aligned({}), "");
}

TEST(TextGrid, RoundsToTheDecimalsAskedFor) {
  EXPECT_EQ(fixed(1.256, 2), "1.26");
  EXPECT_EQ(fixed(-0.5, 0), "-0");
}

}  // namespace
}  // namespace sightline
