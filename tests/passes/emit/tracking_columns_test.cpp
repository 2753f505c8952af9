#include "passes/emit/tracking_columns.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "formats/reader/site_errors.h"

namespace sightline {
namespace {

// A site every metre on two runs of 20. Ends: `kept` of the start along the way and a bias across.
struct Street {
  Sites sites;
  MeasuredError measured;
};

Street make_street(float kept, float lateral_m) {
  Street street;
  MeasuredError& measured = street.measured;
  measured.looks = every_return_at({10.0, 50.0});
  measured.tracking_offsets = {{0.2, 0.0, 0.0, 0.0}, {-0.2, 0.0, 0.0, 0.0}};
  for (std::uint32_t i = 0; i < 40; ++i) {
    Site& site = street.sites.sites.emplace_back();
    site.run = i / 20;
    site.s_m = i % 20;
    measured.scan_of_site.push_back(i);
    for (int end = 0; end < 2; ++end) measured.tracking_ends.emplace_back();  // of 10 m
    measured.tracking_ends.push_back({0.2F * kept, lateral_m, 0.0F, 0.003F});
    measured.tracking_ends.push_back({-0.2F * kept, lateral_m, 0.0F, -0.003F});
  }
  measured.rows.resize(80);
  return street;
}

std::vector<SiteColumn> columns_of(const Street& street) {
  return tracking_columns(street.measured, 1, street.sites, kTrackingRangeColumns);
}

TEST(TrackingColumns, AreRootMeanSquaresAboutTheReferenceWithinAStep) {
  const std::vector<SiteColumn> columns = columns_of(make_street(0.5F, 0.04F));
  ASSERT_EQ(columns.size(), 4U);
  const double expected[] = {0.1, 0.04, 0.003, 0.5};
  for (std::size_t i = 0; i < columns.size(); ++i) {
    EXPECT_TRUE(validate(columns[i]).has_value());
    EXPECT_EQ(columns[i].name, kTrackingRangeColumns[i]);
    EXPECT_EQ(std::set(columns[i].values.begin(), columns[i].values.end()).size(), 1U);
    EXPECT_NEAR(columns[i].values[7], expected[i], 0.03 * expected[i]);
  }
}

TEST(TrackingColumns, PoolTheSitesOfTheRunWithinFiveMetres) {
  Street street = make_street(0.0F, 0.0F);
  // The last site of the first run is 1.1 m off to the side.
  for (std::size_t end = 2; end < 4; ++end) {
    street.measured.tracking_ends[19 * 4 + end].lateral_m = 1.1F;
  }
  const std::vector<float> lateral_m = columns_of(street)[1].values;
  EXPECT_NEAR(lateral_m[19], 1.1 / std::sqrt(6.0), 0.02) << "sites 14 to 19";
  EXPECT_NEAR(lateral_m[14], 1.1 / std::sqrt(11.0), 0.02) << "sites 9 to 19";
  EXPECT_LT(lateral_m[13], 0.002F);
  EXPECT_LT(lateral_m[20], 0.002F) << "of another run";
}

TEST(TrackingColumns, AreInfiniteWhereNothingWasMeasured) {
  Street street = make_street(0.5F, 0.04F);
  for (std::size_t site = 0; site < 12; ++site) street.measured.scan_of_site[site] = -1;
  const std::vector<SiteColumn> columns = columns_of(street);
  for (const SiteColumn& column : columns) {
    EXPECT_TRUE(validate(column).has_value());
    EXPECT_TRUE(std::isinf(column.values[6]));
    EXPECT_TRUE(std::isfinite(column.values[7])) << "site 12 is 5 m away";
  }
}

TEST(TrackingColumns, AreOfTheLongestRangeAndOfTheFirstSampleOf64Points) {
  MeasuredError measured = make_street(0.0F, 0.0F).measured;
  EXPECT_EQ(tracking_look(measured), 1U);
  measured.looks = {{.range_m = 100.0, .return_count = 400, .point_count = 32},
                    {.range_m = 100.0, .return_count = 900, .point_count = 64},
                    {.range_m = 100.0, .return_count = 2000, .point_count = 80}};
  EXPECT_EQ(tracking_look(measured), 1U);
  measured.looks.resize(1);
  EXPECT_EQ(tracking_look(measured), 0U);
  measured.tracking_offsets.clear();
  EXPECT_EQ(tracking_look(measured), std::nullopt);
}

}  // namespace
}  // namespace sightline
