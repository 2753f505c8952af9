#include "passes/replay/find_place.h"

#include <gtest/gtest.h>

#include <utility>

#include "formats/base/files/atomic_file.h"
#include "formats/map/map_writer.h"
#include "passes/map/build_ndt.h"
#include "passes/vehicle/c_values.h"
#include "tests/formats/map/random_map.h"
#include "tests/support/box_world.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/test_context.h"

namespace sightline {
namespace {

constexpr double kApart_m = 192.0;

SensorProfile sensor() {
  SensorProfile sensor;
  sensor.T_vehicle_lidar.translation() = Eigen::Vector3d(0.0, 0.0, 2.0);
  return sensor;
}

CompiledMap map_without_nds() {
  return random_map({.site_count = 10, .run_count = 1, .looks = {}});
}

const MapFrame& frame() {
  static const MapFrame kFrame = map_without_nds().ndt.frame;
  return kFrame;
}

Scan scan_at(std::uint64_t street, const Pose& T_map_vehicle) {
  return scan_world(random_street(street), T_map_vehicle * sensor().T_vehicle_lidar, 1.0);
}

constexpr double kLength_m = 36.0;

// Of a street along x from 0 to 36 m.
std::vector<Eigen::Vector3d> points_of(std::uint64_t street) {
  std::vector<Eigen::Vector3d> points_m;
  for (double x_m = 0.0; x_m < kLength_m; x_m += 2.0) {
    const Pose T_map_lidar = lidar_at(x_m, 0.0, 0.0);
    for (const Eigen::Vector3d& point_m :
         scan_world(random_street(street), T_map_lidar, 1.0).points_m) {
      points_m.emplace_back(T_map_lidar * point_m);
    }
  }
  return points_m;
}

// Each street 192 m farther along x than the one before it: whole tiles.
NdtMap nds_of(const std::vector<std::uint64_t>& streets) {
  NdtMap all;
  for (std::size_t n = 0; n < streets.size(); ++n) {
    NdtMap one = ndt_from_points(points_of(streets[n]), frame(), {}, 1);
    const double moved_m = kApart_m * static_cast<double>(n);
    for (Nd& nd : one.nds) {
      nd.mean_m.x() += moved_m;
      nd.key.x += static_cast<int>(moved_m / one.cell_m);
    }
    if (n > 0) one.nds.insert(one.nds.begin(), all.nds.begin(), all.nds.end());
    all = std::move(one);
  }
  return all;
}

// A street twice, its points the second time so much farther along x.
NdtMap nds_of_moved_points(std::uint64_t street, double moved_m) {
  std::vector<Eigen::Vector3d> points_m = points_of(street);
  const std::vector<Eigen::Vector3d> once_m = points_m;
  for (const Eigen::Vector3d& point_m : once_m) {
    points_m.emplace_back(point_m + Eigen::Vector3d(moved_m, 0.0, 0.0));
  }
  return ndt_from_points(points_m, frame(), {}, 1);
}

// A map of such streets, of which each begins so much farther along x than the one before it.
class MapOfStreets {
 public:
  MapOfStreets(const NdtMap& nds, std::size_t street_count, double apart_m) {
    for (std::size_t n = 0; n < street_count; ++n) {
      for (double x_m = 0.0; x_m < kLength_m; x_m += 2.0) {
        const double at_m = x_m + apart_m * static_cast<double>(n);
        route_m_.emplace_back(frame().origin_world_m + lidar_at(at_m, 0.0, 0.0).translation());
      }
    }
    CompiledMap map = map_without_nds();
    map.ndt = nds;
    map.measurement.localizer.name = "searching";
    map.sensor.T_vehicle_lidar = sensor().T_vehicle_lidar;
    const std::filesystem::path path = scratch_folder() / "streets.slmap";
    EXPECT_TRUE(write_file_atomically(path, encode_map(map), IfExists::kReplace));
    sightline_localizer_options whole{};
    whole.holds_whole_map = 1;
    localizer_.emplace(value_of(VehicleLocalizer::open(path.string(), whole)));
    check_.emplace(localizer_->info());
    finder_.emplace(check_->map(), route_m_, sensor().T_vehicle_lidar);
  }

  explicit MapOfStreets(const std::vector<std::uint64_t>& streets)
      : MapOfStreets(nds_of(streets), streets.size(), kApart_m) {}

  [[nodiscard]] std::optional<FoundPlace> find(const Scan& scan, int threads = 1) const {
    MapLook look;
    look.range_m = 50.0;
    return value_of(find_place({*localizer_, *check_, *finder_, look}, scan,
                               upright_of(scan, sensor()), threads));
  }

 private:
  std::vector<Eigen::Vector3d> route_m_;
  std::optional<VehicleLocalizer> localizer_;
  std::optional<PlaceCheck> check_;
  std::optional<PlaceFinder> finder_;
};

Eigen::Vector3d position_map_m(const FoundPlace& place) {
  const double* const rows = place.match.T_world_vehicle;
  return Eigen::Vector3d(rows[3], rows[7], rows[11]) - frame().origin_world_m;
}

TEST(FindPlace, FindsAScanAtAnyHeading) {
  const MapOfStreets map({20});
  for (const double yaw_rad : {0.1, 1.5, 3.0, -2.0}) {
    const Pose T_map_vehicle = pose_at(11.3, 1.2, yaw_rad);
    const std::optional<FoundPlace> place = map.find(scan_at(20, T_map_vehicle));
    ASSERT_TRUE(place) << yaw_rad;
    EXPECT_LT((position_map_m(*place) - T_map_vehicle.translation()).norm(), 0.5) << yaw_rad;
    EXPECT_GT(place->met_share, 0.5);
    EXPECT_TRUE(is_sure(*place));
  }
}

TEST(FindPlace, ShowsWhereTwoPlacesAreAlike) {
  const MapOfStreets map({20, 20});
  const std::optional<FoundPlace> place = map.find(scan_at(20, pose_at(11.3, 0.2, 0.1)));
  ASSERT_TRUE(place);
  EXPECT_FALSE(is_sure(*place)) << place->likelihood << " " << place->likelihood_elsewhere;
}

// Walls at the edges of cells fall into other cells where coordinates round otherwise, so that the
// wrong street can be the likelier one.
TEST(FindPlace, IsNotSureWhereTwoPlacesDifferInTheirCellsAlone) {
  const MapOfStreets map(nds_of_moved_points(20, 150.0), 2, 150.0);
  for (const double x_m : {5.0, 11.3, 18.0, 25.0}) {
    const std::optional<FoundPlace> place = map.find(scan_at(20, pose_at(x_m, 0.2, 0.1)));
    ASSERT_TRUE(place) << x_m;
    EXPECT_FALSE(is_sure(*place)) << x_m << ": " << place->likelihood << " "
                                  << place->likelihood_elsewhere;
  }
}

TEST(FindPlace, FindsTheRightOneOfTwoStreets) {
  const MapOfStreets map({33, 20});
  const std::optional<FoundPlace> place = map.find(scan_at(20, pose_at(11.3, 0.2, 0.1)));
  ASSERT_TRUE(place);
  EXPECT_NEAR(position_map_m(*place).x(), kApart_m + 11.3, 0.5);
  EXPECT_TRUE(is_sure(*place));
}

TEST(FindPlace, IsTheSameForAnyNumberOfThreads) {
  const MapOfStreets map({33, 20});
  const Scan scan = scan_at(20, pose_at(5.0, -0.4, 3.1));
  const std::optional<FoundPlace> one = map.find(scan, 1);
  const std::optional<FoundPlace> four = map.find(scan, 4);
  ASSERT_TRUE(one && four);
  EXPECT_EQ(position_map_m(*one), position_map_m(*four));
  EXPECT_EQ(one->likelihood_elsewhere, four->likelihood_elsewhere);
}

FoundPlace place_at(double x_m, double likelihood, double likelihood_elsewhere) {
  FoundPlace place;
  put_pose(Pose(Eigen::Translation3d(x_m, 0.0, 0.0)), place.match.T_world_vehicle);
  place.likelihood = likelihood;
  place.likelihood_elsewhere = likelihood_elsewhere;
  return place;
}

TEST(FindPlace, IsUnsureWhereAnotherMapShowsAnotherPlaceAsWell) {
  const FoundPlace here = place_at(0.0, 4.0, 1.0);
  const FoundPlace there = place_at(50.0, 3.9, 1.0);
  EXPECT_TRUE(is_sure(here));
  EXPECT_FALSE(is_sure(likelier_of(here, there)));
  EXPECT_FALSE(is_sure(likelier_of(there, here)));
  EXPECT_EQ(likelier_of(there, here).likelihood, 4.0);
}

TEST(FindPlace, IsSureOfAPlaceThatTwoMapsShow) {
  const FoundPlace one = place_at(0.0, 4.0, 1.0);
  const FoundPlace two = place_at(0.2, 4.1, 1.0);
  EXPECT_TRUE(is_sure(likelier_of(one, two)));
  EXPECT_EQ(likelier_of(one, two).likelihood, 4.1);
  const FoundPlace has_other = place_at(0.2, 3.9, 3.8);
  EXPECT_EQ(likelier_of(one, has_other).likelihood_elsewhere, 3.8);
}

}  // namespace
}  // namespace sightline
