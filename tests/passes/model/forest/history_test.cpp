#include "passes/model/forest/history.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/synthetic_places.h"

namespace sightline {
namespace {

// Three sites 4 m apart and one far away, two ranges; the drive measured the first two.
DrivenPlace small_place() {
  DrivenPlace place = place_driven_twice(
      1, {.site_count = 4, .ranges_m = {10.0, 20.0}, .has_paper_factors = false});
  for (std::size_t i = 0; i < 4; ++i) {
    place.sites.sites[i].p_map_m = Eigen::Vector3d(4.0 * static_cast<double>(i), 0.0, 0.0);
  }
  place.sites.sites[3].p_map_m.x() = 40.0;
  MeasuredError& drive = place.drives[0];
  drive.scan_of_site = {0, 1, -1, -1};
  const double errors_m[] = {0.1, 0.05, 0.4, 0.2};
  for (std::size_t i = 0; i < 4; ++i) {
    drive.rows[i] = ErrorRow{};
    drive.rows[i].mean_m = errors_m[i];
    drive.rows[i].p90_m = 2.0 * errors_m[i];
  }
  drive.rows[2].lost_share = 0.25;  // second site, 10 m
  return place;
}

float value(const History& history, std::size_t site, std::size_t range, const char* name) {
  const std::vector<std::string>& names = history_features(history.kind);
  const auto feature =
      static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  EXPECT_LT(feature, names.size());
  return history.values[(site * 2 + range) * names.size() + feature];
}

TEST(History, TellsWhatTheNearestMeasuredSiteFoundAndItsNeighbours) {
  const DrivenPlace place = small_place();
  const History history = history_of(place.sites, {&place.drives[0]}, HistoryKind::kOfOneDrive);
  EXPECT_EQ(history.is_known, (std::vector<std::uint8_t>{1, 1, 1, 0}));
  const auto log_of = [](double x) { return static_cast<float>(std::log(x)); };
  EXPECT_EQ(value(history, 0, 0, "history_known"), 1.0F);
  EXPECT_EQ(value(history, 0, 0, "history_log_mean"), log_of(0.1));
  EXPECT_EQ(value(history, 0, 0, "history_log_mean_shorter"), log_of(0.1));
  EXPECT_EQ(value(history, 0, 0, "history_log_mean_longer"), log_of(0.05));
  EXPECT_EQ(value(history, 0, 1, "history_log_mean_shorter"), log_of(0.1));
  EXPECT_NEAR(value(history, 0, 0, "history_log_mean_near"), std::log(0.2), 1e-6);
  EXPECT_EQ(value(history, 0, 0, "history_log_max_near"), log_of(0.4));
  EXPECT_EQ(value(history, 0, 0, "history_log_p90"), log_of(0.2));
  EXPECT_EQ(value(history, 0, 0, "history_lost_near"), 0.25F);
  // The third was not measured: the second is 4 m away, the first 8 m and too far.
  EXPECT_EQ(value(history, 2, 0, "history_log_max_near"), log_of(0.4));
  EXPECT_NEAR(value(history, 2, 1, "history_log_mean_near"), std::log(0.2), 1e-6);
  EXPECT_EQ(value(history, 3, 0, "history_known"), 0.0F);
  EXPECT_EQ(value(history, 3, 0, "history_log_mean"), 0.0F);
}

TEST(History, FindsNeighboursAsASearchThroughAllDoes) {
  SyntheticOptions options = {.site_count = 120, .ranges_m = {10.0}, .has_paper_factors = false};
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    DrivenPlace place = place_driven_twice(seed, options);
    Random random(seed);
    for (Site& site : place.sites.sites) {
      site.p_map_m = Eigen::Vector3d(random.uniform(-20.0, 20.0), random.uniform(-20.0, 20.0),
                                     random.uniform(-2.0, 2.0));
    }
    for (std::int64_t& scan : place.drives[0].scan_of_site)
      if (random.uniform() < 0.5) scan = -1;
    const History history = history_of(place.sites, {&place.drives[0]}, HistoryKind::kOfOneDrive);
    for (std::size_t i = 0; i < 120; ++i) {
      double worst_m = 0.0;
      for (std::size_t j = 0; j < 120; ++j) {
        const bool is_measured = place.drives[0].scan_of_site[j] >= 0;
        const Eigen::Vector3d apart_m = place.sites.sites[i].p_map_m - place.sites.sites[j].p_map_m;
        if (is_measured && apart_m.norm() <= 6.0 && std::abs(apart_m.z()) < 1.0) {
          worst_m = std::max(worst_m, place.drives[0].row(j, 0).mean_m);
        }
      }
      EXPECT_EQ(history.is_known[i] != 0, worst_m > 0.0);
      const float worst = history.values[i * history_features().size() + 5];
      EXPECT_EQ(worst, worst_m > 0.0 ? static_cast<float>(std::log(worst_m)) : 0.0F);
    }
  }
}

// Independent of the code: every number from its definition, by a search through all sites.
TEST(History, TellsWhatSeveralDrivesFoundAndHowTheyDiffer) {
  const SyntheticOptions options = {
      .site_count = 40, .ranges_m = {10.0, 20.0}, .has_paper_factors = false};
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    DrivenPlace place = place_driven_often(seed, 4, options);
    Random random(seed);
    for (Site& site : place.sites.sites) {
      site.p_map_m = Eigen::Vector3d(random.uniform(0.0, 60.0), random.uniform(-2.0, 2.0), 0.0);
    }
    for (MeasuredError& drive : place.drives) {
      for (std::int64_t& scan : drive.scan_of_site) scan = random.uniform() < 0.3 ? 1 : -1;
    }
    const EarlierDrives drives = {&place.drives[0], &place.drives[2], &place.drives[3]};
    const History history = history_of(place.sites, drives, HistoryKind::kOfSeveral);
    for (std::size_t site = 0; site < 40; ++site) {
      std::vector<double> nearest, all;
      for (const MeasuredError* drive : drives) {
        double least_m = 6.0;
        double nearest_m = -1.0;
        for (std::size_t other = 0; other < 40; ++other) {
          const double apart_m =
              (place.sites.sites[site].p_map_m - place.sites.sites[other].p_map_m).norm();
          if (drive->scan_of_site[other] < 0 || apart_m > 6.0) continue;
          all.push_back(std::log(drive->row(other, 1).mean_m));
          if (apart_m <= least_m) nearest_m = drive->row(other, 1).mean_m;
          least_m = std::min(least_m, apart_m);
        }
        if (nearest_m > 0.0) nearest.push_back(std::log(nearest_m));
      }
      EXPECT_EQ(history.is_known[site] == 1, !nearest.empty());
      if (nearest.empty()) continue;
      std::ranges::sort(all);
      double mean = 0.0;
      for (const double log : nearest) mean += log / static_cast<double>(nearest.size());
      const double most = all[static_cast<std::size_t>(0.9 * static_cast<double>(all.size() - 1))];
      EXPECT_EQ(value(history, site, 1, "history_drives"), static_cast<float>(nearest.size()));
      EXPECT_NEAR(value(history, site, 1, "history_log_mean"), mean, 1e-5);
      EXPECT_NEAR(value(history, site, 1, "history_log_worst"), std::ranges::max(nearest), 1e-5);
      EXPECT_NEAR(value(history, site, 1, "history_log_worst_near"), all.back(), 1e-5);
      EXPECT_NEAR(value(history, site, 1, "history_log_most_near"), most, 1e-5);
    }
  }
}

TEST(History, OfOneDriveIsTheSameAmongSeveral) {
  const DrivenPlace place = small_place();
  const History one = history_of(place.sites, {&place.drives[0]}, HistoryKind::kOfOneDrive);
  const History several = history_of(place.sites, {&place.drives[0]}, HistoryKind::kOfSeveral);
  EXPECT_EQ(one.is_known, several.is_known);
  for (const std::string& name : history_features()) {
    for (std::size_t site = 0; site < 4; ++site) {
      EXPECT_EQ(value(one, site, 1, name.c_str()), value(several, site, 1, name.c_str())) << name;
    }
  }
  EXPECT_EQ(history_kind_of(history_features()), HistoryKind::kOfOneDrive);
  EXPECT_EQ(history_kind_of(history_features(HistoryKind::kOfSeveral)), HistoryKind::kOfSeveral);
}

TEST(History, GoesBeforeTheRange) {
  FeatureRows rows;
  rows.names = {"a", "range_m"};
  rows.row_count = 2;
  rows.values = {1.0F, 10.0F, 2.0F, 20.0F};
  const FeatureRows with_earlier = with_history(rows, HistoryKind::kOfOneDrive, nullptr);
  ASSERT_EQ(with_earlier.names.size(), 2u + history_features().size());
  EXPECT_EQ(with_earlier.names.front(), "a");
  EXPECT_EQ(with_earlier.names[1], "history_known");
  EXPECT_EQ(with_earlier.names.back(), "range_m");
  EXPECT_EQ(with_earlier.row(1)[0], 2.0F);
  EXPECT_EQ(with_earlier.row(1)[1], 0.0F);
  EXPECT_EQ(with_earlier.row(1)[with_earlier.names.size() - 1], 20.0F);
}

}  // namespace
}  // namespace sightline
