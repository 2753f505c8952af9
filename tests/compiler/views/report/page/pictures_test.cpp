#include "compiler/views/report/page/pictures.h"

#include <gtest/gtest.h>

#include "formats/base/random.h"

namespace sightline {
namespace {

Site site_at(double x_m, double y_m, double z_m) {
  Site site;
  site.p_map_m = {x_m, y_m, z_m};
  return site;
}

TEST(Relief, RoadIsAsHighAsTheNearestSiteSays) {
  Sites sites;
  Random random(5);
  for (int i = 0; i < 200; ++i) {
    // A spot each, so that none hides another.
    sites.sites.push_back(site_at(20.0 * (i % 20), 20.0 * (i / 20), random.uniform(0.0, 9.0)));
  }
  const RoadHeight road(sites, 1.5);
  for (int k = 0; k < 500; ++k) {
    const double x_m = random.uniform(-50.0, 450.0);
    const double y_m = random.uniform(-50.0, 250.0);
    const auto apart_m = [&](const Site& site) {
      return std::hypot(site.p_map_m.x() - x_m, site.p_map_m.y() - y_m);
    };
    const auto nearest =
        std::min_element(sites.sites.begin(), sites.sites.end(),
                         [&](const Site& a, const Site& b) { return apart_m(a) < apart_m(b); });
    EXPECT_DOUBLE_EQ(road.at(x_m, y_m), nearest->p_map_m.z() - 1.5);
  }
  EXPECT_EQ(RoadHeight(Sites{}, 1.0).at(3.0, 4.0), 0.0);
}

TEST(Relief, TheHighestPatchIsSeenAndNothingIsZero) {
  Sites sites;
  sites.sites = {site_at(0.0, 0.0, 2.0)};
  const RoadHeight road(sites, 2.0);
  Surface surface;
  surface.patches = {{{0, 0, 0}, {1.0, 1.0, 0.0}, {0, 0, 1}, 0.5},
                     {{0, 0, 1}, {1.0, 1.0, 3.0}, {0, 0, 1}, 0.5},
                     {{0, 1, 0}, {3.0, 1.0, 40.0}, {1, 0, 0}, 0.5}};
  const GreyRaster raster = relief_picture(surface, {0, 1, 2}, road, {0.0, 0.0, 4.0, 2.0}, 0.5);
  ASSERT_EQ(raster.width, 8U);
  ASSERT_EQ(raster.height, 4U);
  EXPECT_NEAR(relief_height_m(raster.at(2, 2)), 3.0, 0.03);
  EXPECT_EQ(raster.at(0, 0), 0);
  EXPECT_EQ(raster.at(6, 2), 255);  // as high as can be shown
  EXPECT_EQ(raster.at(4, 2), 0);    // beside the wall
}

}  // namespace
}  // namespace sightline
