#include "compiler/views/picture/dump_picture.h"

#include <gtest/gtest.h>

#include <limits>

namespace sightline {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Azimuths 45, 135, 225 and 315 degrees, two elevations, one site.
DepthImages four_by_two() {
  DepthImages images;
  images.azimuth_count = 4;
  images.elevation_count = 2;
  images.site_count = 1;
  images.distance_m = {kInfinity, 50.0F, 50.0F, 50.0F,  // below
                       50.0F,     0.5F,  50.0F, 50.0F};
  return images;
}

TEST(DepthPicture, ShowsAheadInTheMiddleLeftToTheLeftAndUpAbove) {
  const Raster raster = depth_picture(four_by_two(), 0);
  ASSERT_EQ(raster.width, 16U);
  ASSERT_GT(raster.height, 8U);
  const Colour far = colour_of_distance(50.0, 50.0);
  // From the left: 135, 45, 315, 225 degrees. The one near cell is at 135 degrees above.
  EXPECT_EQ(raster.at(0, 0), colour_of_distance(0.5, 50.0));
  EXPECT_EQ(raster.at(4, 0), far);
  EXPECT_EQ(raster.at(0, 7), far);
  EXPECT_EQ(raster.at(7, 7), colour_of_distance(static_cast<double>(kInfinity), 50.0));
  EXPECT_EQ(raster.at(8, 7), far);
}

TEST(DepthPicture, DarkensWithDistance) {
  int before = 1000;
  for (double distance_m = 0.0; distance_m <= 50.0; distance_m += 0.5) {
    const Colour colour = colour_of_distance(distance_m, 50.0);
    const int brightness = (3 * colour.red + 6 * colour.green + colour.blue) / 10;
    EXPECT_LE(brightness, before);
    before = brightness;
  }
}

}  // namespace
}  // namespace sightline
