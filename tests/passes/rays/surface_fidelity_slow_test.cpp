#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "examples/town/drive/drive.h"
#include "examples/town/whole/town.h"
#include "passes/map/build_surface.h"
#include "passes/rays/cast_rays.h"
#include "tests/support/test_context.h"
#include "tests/support/whole_rows.h"

// The surface that rays meet against the exact triangles that the scans were made from.

namespace sightline {
namespace {

constexpr double kStreet_m = 80.0;
constexpr std::size_t kSiteEvery = 16;  // scans

struct TownViews {
  SurfacePoints points;  // of the mapping drive, without what moved
  Sites sites;
  std::vector<double> exact_m;  // as depth images lie; +inf beyond 50 m
};

Eigen::Vector3d direction_of(int row, int column) {
  const double elevation_rad = (row - 15) * std::numbers::pi / 180.0;
  const double azimuth_rad = (column + 0.5) * std::numbers::pi / 180.0;
  return {std::cos(elevation_rad) * std::cos(azimuth_rad),
          std::cos(elevation_rad) * std::sin(azimuth_rad), std::sin(elevation_rad)};
}

void look(const town::TownCaster& caster, const Eigen::Vector3d& p_m,
          std::vector<double>& exact_m) {
  constexpr double kNear_m = 0.5;
  for (int row = 0; row < 31; ++row) {
    for (int column = 0; column < 360; ++column) {
      const Eigen::Vector3d direction = direction_of(row, column);
      const double range_m = kNear_m + caster.exact_range_m(p_m + kNear_m * direction, direction);
      exact_m.push_back(range_m <= 50.0 ? range_m : std::numeric_limits<double>::infinity());
    }
  }
}

TownViews drive_through(std::uint64_t seed) {
  town::TownOptions options;
  options.seed = seed;
  options.length_m = kStreet_m;
  const Result<town::Town> town = town::make_town(options);
  const Result<SensorProfile> sensor = town::town_sensor(16);
  const Result<town::DriveSimulator> drive =
      town::DriveSimulator::make(*town, town::usual_drive(options, 0, *sensor));
  const std::vector<Pose> poses = drive->disturbed_poses();
  TownViews views;
  for (std::size_t i = 0; i < drive->scan_count(); ++i) {
    const Pose T_town_lidar = poses[i] * sensor->T_vehicle_lidar;
    for (const town::LabelledPoint& point : drive->scan(i).points) {
      if (town::is_moving(point.label)) continue;
      views.points.points_m.emplace_back(T_town_lidar * point.position_m.cast<double>());
    }
    if (i % kSiteEvery != kSiteEvery / 2) continue;
    Site site;
    site.p_map_m = (drive->T_town_vehicle()[i] * sensor->T_vehicle_lidar).translation();
    views.sites.sites.push_back(site);
    look(drive->standing(), site.p_map_m, views.exact_m);
  }
  return views;
}

double quantile(std::vector<double> values, double share) {
  const auto at = static_cast<long>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

struct Fidelity {
  double agreement = 0.0;  // share of rays on which both hit or both miss
  double median_m = 0.0;   // of the distance's error where both hit
  double p95_m = 0.0;
};

Fidelity fidelity_of(const DepthImages& images, const std::vector<double>& exact_m,
                     std::uint32_t first, std::uint32_t last) {
  double agreements = 0.0;
  double rays = 0.0;
  std::vector<double> error_m;
  for (std::size_t i = 0; i < exact_m.size(); ++i) {
    const std::size_t row = i % images.cells_per_site() / images.azimuth_count;
    if (row < first || row >= last) continue;
    const double found_m = images.distance_m[i];
    const bool is_hit = std::isfinite(exact_m[i]);
    rays += 1.0;
    agreements += is_hit == std::isfinite(found_m) ? 1.0 : 0.0;
    if (is_hit && std::isfinite(found_m)) error_m.push_back(std::abs(found_m - exact_m[i]));
  }
  return {agreements / rays, quantile(error_m, 0.5), quantile(error_m, 0.95)};
}

class SurfaceFidelity : public testing::TestWithParam<std::uint64_t> {};

TEST_P(SurfaceFidelity, AgreesWithTheExactTownInEveryElevationBand) {
  const TownViews views = drive_through(GetParam());
  const Surface surface = value_of(whole_rows(build_surface(TestContext(), {}, views.points)));
  const DepthImages images =
      value_of(cast_rays(TestContext(), {}, surface, views.sites, SensorProfile()));
  ASSERT_EQ(images.distance_m.size(), views.exact_m.size());
  const Fidelity all = fidelity_of(images, views.exact_m, 0, 31);
  EXPECT_GE(all.agreement, 0.97);
  EXPECT_LE(all.median_m, 0.10);
  EXPECT_LE(all.p95_m, 0.5);
  // -15 .. -11, -10 .. -6, ..., 5 .. 9, 10 .. 15 degrees.
  for (std::uint32_t first = 0; first < 30; first += 5) {
    const Fidelity band = fidelity_of(images, views.exact_m, first, first == 25 ? 31 : first + 5);
    // 0.95 and more everywhere but at -5 .. -1 degrees of town 2 (0.939), where rays graze the
    // ground beyond what the drive has sampled.
    EXPECT_GE(band.agreement, first == 10 ? 0.93 : 0.95) << "from row " << first;
    EXPECT_LE(band.median_m, 0.15) << "from row " << first;
    RecordProperty("row_" + std::to_string(first), std::to_string(band.agreement) + " " +
                                                       std::to_string(band.median_m) + " " +
                                                       std::to_string(band.p95_m));
  }
}

INSTANTIATE_TEST_SUITE_P(ThreeTowns, SurfaceFidelity, testing::Values(1, 2, 3));

}  // namespace
}  // namespace sightline
