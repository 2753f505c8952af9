#include "formats/surroundings/depth_images.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/artifact_checks.h"

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
  DepthImages images = small_images();
  images.distance_m.pop_back();
  EXPECT_FALSE(validate(images).has_value());
}

TEST(DepthImages, RefusesADistanceBelowZeroAndTakesOneOutOfView) {
  DepthImages images = small_images();
  images.distance_m[9] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(validate(images).has_value());
  images.distance_m[9] = -1.0F;
  const Result<void> valid = validate(images);
  ASSERT_FALSE(valid.has_value());
  EXPECT_EQ(valid.error().place, "site 1");
}

}  // namespace
}  // namespace sightline
