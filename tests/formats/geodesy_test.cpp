#include "formats/geodesy.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

// Worked out with PROJ 9.1: cs2cs -f %.9f EPSG:32631 EPSG:4326 and so on.
TEST(FromUtm, AgreesWithProj) {
  struct Known {
    UtmZone zone;
    double easting_m, northing_m, longitude_deg, latitude_deg;
  };
  const Known known[] = {
      {{31, false}, 448020.0, 5411968.0, 2.291335628, 48.858498351},
      {{33, false}, 166021.5, 0.0, 12.000000511, 0.000000000},
      {{33, false}, 833978.5, 6000000.0, 20.102016420, 54.039805371},
      {{19, true}, 345678.25, 6298765.5, -70.660173798, -33.439415030},
      {{60, true}, 500000.0, 5000000.0, 177.000000000, -45.153477183},
      {{1, false}, 300000.0, 9000000.0, 171.620893119, 80.884593944},
  };
  for (const Known& k : known) {
    const LongitudeLatitude p = from_utm(k.zone, k.easting_m, k.northing_m);
    EXPECT_NEAR(p.longitude_deg, k.longitude_deg, 1e-8);  // 1 mm
    EXPECT_NEAR(p.latitude_deg, k.latitude_deg, 1e-8);
  }
}

TEST(UtmZone, IsANumberAndAHemisphere) {
  const Result<UtmZone> zone = parse_utm_zone("33N");
  ASSERT_TRUE(zone);
  EXPECT_EQ(zone->number, 33);
  EXPECT_FALSE(zone->is_south);
  EXPECT_TRUE(parse_utm_zone("1s")->is_south);
  for (const char* wrong : {"", "33", "N", "0N", "61N", "33X", "33NN", "-3N", "3 N"}) {
    const Result<UtmZone> refused = parse_utm_zone(wrong);
    ASSERT_FALSE(refused) << wrong;
    EXPECT_EQ(refused.error().code, ErrorCode::kBadArgument);
  }
}

}  // namespace
}  // namespace sightline
