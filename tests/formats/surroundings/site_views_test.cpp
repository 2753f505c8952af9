#include "formats/surroundings/site_views.h"

#include <gtest/gtest.h>
#include <limits>

#include "tests/support/artifact_checks.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

DepthImages small_images() {
  DepthImages images;
  images.azimuth_count = 4;
  images.elevation_count = 2;
  images.site_count = 2;
  images.distance_m.assign(16, 7.5F);
  images.distance_m[3] = std::numeric_limits<float>::infinity();
  return images;
}

TEST(DepthImages, SurvivesDisk) { expect_survives_disk(small_images()); }

TEST(DepthImages, DumpsTheDirectionOfEveryCell) {
  const Table table = dump(small_images());
  ASSERT_EQ(table.rows.size(), 16U);
  // Site 1, second row, third column of four.
  EXPECT_EQ(table.rows[14], (std::vector<Cell>{std::int64_t{1}, -14.0, 225.0, 7.5}));
}

TEST(DepthImages, RefusesTooFewCells) {
  expect_refused<DepthImages>(small_images(),
                              {[](DepthImages& images) { images.distance_m.pop_back(); }});
}

TEST(DepthImages, RefusesADistanceBelowZeroAndTakesOneOutOfView) {
  DepthImages images = small_images();
  images.distance_m[9] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(validate(images).has_value());
  images.distance_m[9] = -1.0F;
  EXPECT_EQ(failure_of(validate(images)).place, "site 1");
}

VirtualScans three_scans() {
  VirtualScans scans;
  scans.points_m = {{1.0, 2.0, 3.0}, {4.0, 5.0, 6.0}, {7.0, 8.0, 9.0}};
  scans.end = {2, 2, 3};
  return scans;
}

TEST(VirtualScans, SurvivesDisk) { expect_survives_disk(three_scans()); }

TEST(VirtualScans, GivesEachSiteItsOwnPoints) {
  const VirtualScans scans = three_scans();
  EXPECT_EQ(scans.points_of(0).size(), 2U);
  EXPECT_TRUE(scans.points_of(1).empty());
  ASSERT_EQ(scans.points_of(2).size(), 1U);
  EXPECT_EQ(scans.points_of(2)[0], Eigen::Vector3d(7.0, 8.0, 9.0));
}

TEST(VirtualScans, RefusesScansOutOfOrderOrWithoutSiteAndPointsThatAreNotFinite) {
  VirtualScans scans = three_scans();
  scans.end = {2, 1, 3};
  EXPECT_EQ(failure_of(validate(scans)).place, "site 1");
  expect_refused<VirtualScans>(
      three_scans(), {[](VirtualScans& without_site) { without_site.end.back() = 2; },
                      [](VirtualScans& infinite) { infinite.points_m[1].y() = std::nan(""); }});
}

}  // namespace
}  // namespace sightline
