#include "formats/text/table.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(TextGrid, PutsColumnsUnderEachOther) {
  EXPECT_EQ(aligned({{"range (m)", "10", "15"}, {"error", "3.25"}}),
            "range (m)    10  15\nerror      3.25\n");
  EXPECT_EQ(aligned({}), "");
}

}  // namespace
}  // namespace sightline
