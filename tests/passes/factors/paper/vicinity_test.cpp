#include "passes/factors/paper/vicinity.h"

#include <gtest/gtest.h>

#include "passes/factors/paper/feature_count.h"

namespace sightline {
namespace {

Nd nd_at(double x_m) {
  Nd nd;
  nd.mean_m = {x_m, 0.0, 0.0};
  nd.key = cell_key(nd.mean_m, 2.0);
  return nd;
}

TEST(Vicinity, HoldsNdsNearestFirstAndThoseAtExactlyTheRange) {
  const std::vector<Nd> nds = {nd_at(30.0), nd_at(10.0), nd_at(5.0), nd_at(10.5), nd_at(30.5)};
  const std::vector<std::uint32_t> all = {0, 1, 2, 3, 4};
  const Vicinity vicinity = vicinity_of(Eigen::Vector3d::Zero(), nds, all, {10.0, 20.0, 30.0});
  EXPECT_EQ(vicinity.nd_index, (std::vector<std::uint32_t>{2, 1, 3, 0}));
  EXPECT_EQ(vicinity.end, (std::vector<std::size_t>{2, 3, 4}));
  EXPECT_EQ(feature_count(vicinity), (std::vector<double>{2.0, 3.0, 4.0}));
}

TEST(Vicinity, BreaksTiesOfDistanceByCellKey) {
  const std::vector<Nd> nds = {nd_at(5.0), nd_at(-5.0)};
  const std::vector<std::uint32_t> forward = {0, 1};
  const std::vector<std::uint32_t> backward = {1, 0};
  const Eigen::Vector3d p_m = Eigen::Vector3d::Zero();
  EXPECT_EQ(vicinity_of(p_m, nds, forward, {10.0}).nd_index, (std::vector<std::uint32_t>{1, 0}));
  EXPECT_EQ(vicinity_of(p_m, nds, backward, {10.0}).nd_index, (std::vector<std::uint32_t>{1, 0}));
}

TEST(Vicinity, LooksOnlyAtCandidates) {
  const std::vector<Nd> nds = {nd_at(1.0), nd_at(3.0), nd_at(5.0)};
  const std::vector<std::uint32_t> some = {2};
  EXPECT_EQ(vicinity_of(Eigen::Vector3d::Zero(), nds, some, {10.0}).nd_index, some);
}

}  // namespace
}  // namespace sightline
