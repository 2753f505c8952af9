#include "compiler/views/text/describe_drives.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(DescribeDrives, SaysTheDayOfEachDriveAndHowManyTilesAreFromIt) {
  constexpr std::int64_t kMay4_ns = 1'777'852'800'000'000'000;
  const TileDrives tiles{64.0,
                         {{"monday", kMay4_ns, kMay4_ns + 1}, {"test", 0, 5}, {"later", 6, 7}},
                         {{{0, 0}, 0, 3, 0},
                          {{0, 0}, 2, 0, 8},
                          {{0, 1}, 0, 1, 0},
                          {{0, 1}, 1, 2, 0},
                          {{0, 1}, 2, 2, 1},
                          {{0, 2}, 2, 0, 9}}};
  EXPECT_EQ(describe_drives(tiles),
            "drives\n"
            "  monday                 2026-05-04, in 2 tiles\n"
            "  test                   day not known, in 1 tiles\n"
            "  later                  day not known, in 1 tiles, nothing new in 3\n");
}

}  // namespace
}  // namespace sightline
