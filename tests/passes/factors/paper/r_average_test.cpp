#include "passes/factors/paper/r_average.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(RAverage, IsTheMeanDistanceAndTheRangeItselfWhereThereIsNothing) {
  Vicinity vicinity;
  vicinity.ranges_m = {5.0, 10.0, 20.0};
  vicinity.nd_index = {0, 1, 2};
  vicinity.distance_m = {6.0, 8.0, 16.0};
  vicinity.end = {0, 2, 3};
  EXPECT_EQ(r_average(vicinity), (std::vector<double>{5.0, 7.0, 10.0}));
}

}  // namespace
}  // namespace sightline
