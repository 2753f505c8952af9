#include "formats/surface.h"

#include <gtest/gtest.h>

#include "tests/support/artifact_checks.h"

namespace sightline {
namespace {

Surface two_discs() {
  Surface surface;
  surface.cell_m = 0.5;
  surface.tile_m = 64.0;
  surface.discs.push_back({{0, 0, 0}, {0.25, 0.2, 0.1}, {0.0, 0.6, 0.8}, 0.3});
  surface.discs.push_back({{0, 1, 0}, {0.25, 0.7, 0.1}, {1.0, 0.0, 0.0}, 0.2});
  return surface;
}

TEST(Surface, SurvivesDisk) { expect_survives_disk(two_discs()); }

TEST(Surface, RefusesANormalThatIsNotOfUnitLength) {
  Surface surface = two_discs();
  surface.discs[1].normal *= 1.01;
  const Result<void> valid = validate(surface);
  ASSERT_FALSE(valid.has_value());
  EXPECT_EQ(valid.error().place, "disc 1");
}

TEST(Surface, RefusesADiscOfNoWidth) {
  Surface surface = two_discs();
  surface.discs[0].radius_m = 0.0;
  EXPECT_FALSE(validate(surface).has_value());
}

TEST(Surface, RefusesDiscsOutOfOrder) {
  Surface surface = two_discs();
  std::swap(surface.discs[0], surface.discs[1]);
  EXPECT_FALSE(validate(surface).has_value());
}

}  // namespace
}  // namespace sightline
