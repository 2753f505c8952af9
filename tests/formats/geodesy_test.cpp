#include "formats/geodesy.h"

#include <gtest/gtest.h>

#include "tests/support/value_of.h"

namespace sightline {
namespace {

// Worked out with PROJ 9.1: cs2cs -f %.9f EPSG:32631 EPSG:4326 and so on.
TEST(Utm, AgreesWithProj) {
  struct Known {
    const char* world;
    double easting_m, northing_m, longitude_deg, latitude_deg;
  };
  const Known known[] = {
      {"utm:31N", 448020.0, 5411968.0, 2.291335628, 48.858498351},
      {"utm:33N", 166021.5, 0.0, 12.000000511, 0.000000000},
      {"utm:33N", 833978.5, 6000000.0, 20.102016420, 54.039805371},
      {"utm:19S", 345678.25, 6298765.5, -70.660173798, -33.439415030},
      {"utm:60S", 500000.0, 5000000.0, 177.000000000, -45.153477183},
      {"utm:1N", 300000.0, 9000000.0, 171.620893119, 80.884593944},
      {"utm:32N", 456500.0, 5429500.0, 8.405068475, 49.016855311},  // Karlsruhe's castle
  };
  for (const Known& k : known) {
    const Geodetic p =
        value_of(to_geodetic(*parse_world(k.world), {k.easting_m, k.northing_m, 115.0}), k.world);
    EXPECT_NEAR(p.longitude_deg, k.longitude_deg, 1e-9) << k.world;  // the digits given
    EXPECT_NEAR(p.latitude_deg, k.latitude_deg, 1e-9) << k.world;
    EXPECT_EQ(p.altitude_m, 115.0);
  }
}

TEST(Utm, RefusesAPointThatIsNotOfTheZone) {
  EXPECT_EQ(code_of(to_geodetic(*parse_world("utm:32N"), {2.0e6, 0.0, 0.0})),
            ErrorCode::kBadArgument);
}

TEST(Enu, IsATangentPlaneAtItsOrigin) {
  const Geodetic north = value_of(to_geodetic(*parse_world("enu:49,8.4,100"), {0.0, 1000.0, 0.0}));
  EXPECT_NEAR(north.latitude_deg, 49.0 + 1000.0 / 111'209.0, 2e-5);
  EXPECT_NEAR(north.longitude_deg, 8.4, 1e-12);
  EXPECT_NEAR(north.altitude_m, 100.0784, 1e-3);  // Earth curves away below a tangent
}

// By the US Army's own letters: Karlsruhe lies in 32U MV, whose corner is at 400 and 5400 km.
TEST(Mgrs, IsTheSquareOfItsUtmZone) {
  const World square = *parse_world("mgrs:32UMV");
  EXPECT_EQ(square.kind, WorldKind::kMgrs);
  EXPECT_EQ(square.corner_utm_m, Eigen::Vector2d(400'000.0, 5'400'000.0));
  const Geodetic in_square = *to_geodetic(square, {56'500.0, 29'500.0, 115.0});
  const Geodetic in_zone = *to_geodetic(*parse_world("utm:32N"), {456'500.0, 5'429'500.0, 115.0});
  EXPECT_EQ(in_square.latitude_deg, in_zone.latitude_deg);
  EXPECT_EQ(in_square.longitude_deg, in_zone.longitude_deg);
  EXPECT_EQ(*mgrs_square(square, {56'500.0, 29'500.0, 0.0}), "32UMV");
  EXPECT_EQ(*mgrs_square(square, {156'500.0, 29'500.0, 0.0}), "32UNV") << "its neighbour";
  EXPECT_EQ(*mgrs_square(*parse_world("utm:19S"), {345'678.0, 6'298'765.0, 0.0}), "19HCC");
  EXPECT_EQ(epsg_code(square), 32632);
  EXPECT_EQ(epsg_code(*parse_world("utm:19S")), 32719);
}

TEST(World, IsNamedOnceByTheMapOrTheFlag) {
  EXPECT_EQ(named_world("", "utm:32N")->utm_zone, 32);
  EXPECT_EQ(named_world("utm:32N", "local")->utm_zone, 32);
  EXPECT_EQ(named_world("utm:32N", "utm:32N")->utm_zone, 32);
  EXPECT_EQ(named_world("", "local")->kind, WorldKind::kLocal);
  EXPECT_NE(failure_of(named_world("utm:33N", "utm:32N"))
                .message.find("the map contains its own world, utm:32N"),
            std::string::npos);
}

TEST(World, IsRead) {
  EXPECT_EQ(parse_world("local")->kind, WorldKind::kLocal);
  const World south = *parse_world("utm:19S");
  EXPECT_EQ(south.kind, WorldKind::kUtm);
  EXPECT_EQ(south.utm_zone, 19);
  EXPECT_FALSE(south.is_north);
}

TEST(World, RefusesWhatIsNone) {
  for (const char* text : {"", "utm", "utm:", "utm:0N", "utm:61N", "utm:32", "utm:32X", "utm:33NN",
                           "utm:-3N", "enu:1,2", "enu:91,0,0", "enu:1,2,3,4", "mars",
                           "mgrs:", "mgrs:32", "mgrs:32UMV5629", "mgrs:32UMI", "mgrs:BAN"}) {
    const Error error = failure_of(parse_world(text), text);
    EXPECT_EQ(error.code, ErrorCode::kBadArgument);
    EXPECT_EQ(error.message.find("write utm:"), std::string::npos) << text;
  }
}

TEST(World, TellsHowABareZoneIsWritten) {
  EXPECT_NE(failure_of(parse_world("33N")).message.find("write utm:33N"), std::string::npos);
}

TEST(World, NamesTheZoneOfACodeOfEpsg) {
  const auto message = [](const char* text) { return failure_of(parse_world(text), text).message; };
  EXPECT_NE(message("EPSG:32632").find("write utm:32N"), std::string::npos);
  EXPECT_NE(message("epsg:32719").find("write utm:19S"), std::string::npos);
  EXPECT_NE(message("EPSG:25832").find("of EPSG codes"), std::string::npos);
  EXPECT_EQ(message("EPSG:32661").find("write utm"), std::string::npos) << "a pole";
}

}  // namespace
}  // namespace sightline
