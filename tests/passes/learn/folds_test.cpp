#include "passes/learn/folds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "compiler/base/random.h"

namespace sightline {
namespace {

Sites straight_route(std::size_t count) {
  Sites sites;
  for (std::size_t i = 0; i < count; ++i) {
    Site site;
    site.s_m = static_cast<double>(i);
    site.p_map_m.x() = static_cast<double>(i);
    sites.sites.push_back(site);
  }
  return sites;
}

std::vector<std::uint8_t> all_labelled(std::size_t count) {
  return std::vector<std::uint8_t>(count, 1);
}

TEST(Folds, CutTheRouteIntoAsManyBlocksAsFit) {
  const Result<Folds> folds = make_folds(straight_route(200), all_labelled(200), {60.0, 5});
  ASSERT_TRUE(folds.has_value());
  EXPECT_EQ(folds->block_count, 3u);
  EXPECT_EQ(folds->fold_count, 3u);
  EXPECT_EQ(folds->labelled_route_m, 200.0);
  EXPECT_EQ(folds->block_of_site[66], 0u);
  EXPECT_EQ(folds->block_of_site[67], 1u);
  EXPECT_EQ(folds->block_of_site[199], 2u);
}

TEST(Folds, GiveEachBlockItsLengthOfLabelledRoute) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    Random random(seed);
    const std::size_t count = 150 + random.below(400);
    std::vector<std::uint8_t> has_label(count);
    for (std::uint8_t& label : has_label) label = random.uniform() < 0.9 ? 1 : 0;
    const Result<Folds> folds = make_folds(straight_route(count), has_label, {60.0, 5});
    ASSERT_TRUE(folds.has_value());
    EXPECT_TRUE(std::is_sorted(folds->block_of_site.begin(), folds->block_of_site.end()));
    std::map<std::uint32_t, int> labelled_in_block;
    for (std::size_t i = 0; i < count; ++i) {
      labelled_in_block[folds->block_of_site[i]] += has_label[i];
    }
    ASSERT_EQ(labelled_in_block.size(), folds->block_count);
    for (const auto& [block, labelled] : labelled_in_block) EXPECT_GE(labelled, 60);
  }
}

TEST(Folds, LeaveNothingWithinTheBufferOfAFold) {
  const Sites sites = straight_route(400);
  const Result<Folds> folds = make_folds(sites, all_labelled(400), {60.0, 3});
  ASSERT_TRUE(folds.has_value());
  for (std::uint32_t fold = 0; fold < folds->fold_count; ++fold) {
    const std::vector<std::uint8_t> is_near = sites_near_fold(sites, *folds, fold, 25.0);
    for (std::size_t i = 0; i < 400; ++i) {
      double nearest_m = 1e9;
      for (std::size_t j = 0; j < 400; ++j) {
        if (folds->fold_of_site(j) != fold) continue;
        nearest_m = std::min(nearest_m, (sites.sites[i].p_map_m - sites.sites[j].p_map_m).norm());
      }
      EXPECT_EQ(is_near[i] != 0, nearest_m <= 25.0) << "site " << i << ", fold " << fold;
    }
  }
}

TEST(Folds, DoNotLeakWhereTheRouteCrossesItself) {
  Sites sites = straight_route(240);
  // The second half drives the first half again, 2 m to the side.
  for (std::size_t i = 120; i < 240; ++i) {
    sites.sites[i].p_map_m = Eigen::Vector3d(static_cast<double>(i - 120), 2.0, 0.0);
  }
  const Result<Folds> folds = make_folds(sites, all_labelled(240), {60.0, 4});
  ASSERT_TRUE(folds.has_value());
  const std::vector<std::uint8_t> is_near = sites_near_fold(sites, *folds, 0, 25.0);
  EXPECT_EQ(is_near[150], 1);  // beside site 30, which is in fold 0
  EXPECT_EQ(is_near[230], 0);
}

TEST(Folds, RefuseADriveTooShortAndSayWhatIsNeeded) {
  const Result<Folds> folds = make_folds(straight_route(119), all_labelled(119), {60.0, 5});
  ASSERT_FALSE(folds.has_value());
  EXPECT_EQ(folds.error().code, ErrorCode::kDriveTooShort);
  EXPECT_NE(folds.error().message.find("119 m"), std::string::npos);
  EXPECT_NE(folds.error().message.find("120 m"), std::string::npos);
}

TEST(Folds, RefuseARouteWithoutLabels) {
  const Result<Folds> folds =
      make_folds(straight_route(200), std::vector<std::uint8_t>(200, 0), {60.0, 5});
  ASSERT_FALSE(folds.has_value());
  EXPECT_EQ(folds.error().code, ErrorCode::kNoTrainingRows);
}

}  // namespace
}  // namespace sightline
