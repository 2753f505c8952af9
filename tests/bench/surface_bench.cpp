// What should rays meet? Simple shapes made of one cleaned point cloud against the exact triangles
// of the town that it was recorded in: do hits and misses agree, how far off is the distance, what
// does a ray cost. For solid squares elevation by elevation too. `surface_bench [LENGTH_M=150]
// [SEED=1 ...]`; time is CPU time of one thread, shapes taken in turn at every site so that all
// meet the same machine.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <numbers>
#include <set>

#include "examples/town/drive/drive.h"
#include "examples/town/whole/town.h"
#include "formats/base/check.h"
#include "formats/base/stopwatch.h"
#include "formats/surroundings/surface.h"
#include "passes/map/build_ndt.h"
#include "tests/bench/surface_shapes.h"
#include "tests/support/value_of.h"
#include "tests/support/whole_rows.h"

namespace sightline {
namespace {

constexpr int kRows = 31;
constexpr int kColumns = 360;
constexpr std::size_t kSiteEvery = 8;  // scans
constexpr int kBandRows = 5;
constexpr std::size_t kBands = 6;  // -15 .. -11, ..., 5 .. 9, 10 .. 15 degrees

std::vector<Eigen::Vector3f> image_directions() {
  std::vector<Eigen::Vector3f> directions;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const double elevation_rad = (row - 15) * std::numbers::pi / 180.0;
      const double azimuth_rad = (column + 0.5) * std::numbers::pi / 180.0;
      directions.push_back(Eigen::Vector3d(std::cos(elevation_rad) * std::cos(azimuth_rad),
                                           std::cos(elevation_rad) * std::sin(azimuth_rad),
                                           std::sin(elevation_rad))
                               .cast<float>());
    }
  }
  return directions;
}

struct Views {
  SurfacePoints points;
  std::vector<Eigen::Vector3d> sites_m;
  std::vector<std::vector<double>> exact_m;  // of each site; +inf beyond 50 m
};

std::vector<double> look(const town::TownCaster& caster, const Eigen::Vector3d& p_m,
                         const std::vector<Eigen::Vector3f>& directions) {
  constexpr double kNear_m = 0.5;
  std::vector<double> exact_m;
  for (const Eigen::Vector3f& single : directions) {
    const Eigen::Vector3d direction = single.cast<double>();
    const double range_m = kNear_m + caster.exact_range_m(p_m + kNear_m * direction, direction);
    exact_m.push_back(range_m <= 50.0 ? range_m : std::numeric_limits<double>::infinity());
  }
  return exact_m;
}

Views drive_through(std::uint64_t seed, double length_m) {
  town::TownOptions options;
  options.seed = seed;
  options.length_m = length_m;
  const Result<town::Town> town = town::make_town(options);
  const Result<SensorProfile> sensor = town::town_sensor(16);
  SIGHTLINE_CHECK(town && sensor);
  const town::DriveSimulator drive =
      value_of(town::DriveSimulator::make(*town, town::usual_drive(options, 0, *sensor)));
  const std::vector<Pose> poses = drive.disturbed_poses();
  const std::vector<Eigen::Vector3f> directions = image_directions();
  Views views;
  for (std::size_t i = 0; i < drive.scan_count(); ++i) {
    const Pose T_town_lidar = poses[i] * sensor->T_vehicle_lidar;
    for (const town::LabelledPoint& point : drive.scan(i).points) {
      if (town::is_moving(point.label)) continue;
      views.points.points_m.emplace_back(T_town_lidar * point.position_m.cast<double>());
    }
    if (i % kSiteEvery != kSiteEvery / 2) continue;
    views.sites_m.push_back((drive.T_town_vehicle()[i] * sensor->T_vehicle_lidar).translation());
    views.exact_m.push_back(look(drive.standing(), views.sites_m.back(), directions));
  }
  return views;
}

NdtMap cells_of(const SurfacePoints& points, double cell_m) {
  PassContext ctx;
  ctx.threads = 1;
  return value_of(whole_rows(build_ndt(ctx, {cell_m, 64.0, 3}, points)));
}

// One solid square a cell, as wide as the geometric mean of the points' two spreads says (the
// surface before v3, schemas/definitions.md), times `share`; the sides of discs of equal area.
std::vector<FlatPatch> solid_squares(const SurfacePoints& points, double share) {
  constexpr double kCell_m = 0.5;
  std::vector<FlatPatch> patches;
  for (const Nd& nd : cells_of(points, kCell_m).nds) {
    const Eigen::Vector3d sigma_m = nd.eigenvalues_m2.cwiseSqrt();
    SurfacePatch patch;
    patch.normal = nd.eigenvectors.col(2);
    if (patch.normal.z() < 0.0) patch.normal = -patch.normal;
    const double half_side_m =
        std::clamp(2.5 * std::sqrt(sigma_m[0] * sigma_m[1]), 0.18 * kCell_m, 0.7 * kCell_m);
    const Eigen::Vector3d u_m = share * half_side_m * side_of(patch);
    patches.push_back({nd.mean_m, u_m, patch.normal.cross(u_m)});
  }
  return patches;
}

std::vector<FlatPatch> rectangles(const SurfacePoints& points, double half_per_sigma) {
  std::vector<FlatPatch> patches;
  for (const Nd& nd : cells_of(points, 0.5).nds) {
    const Eigen::Vector3d half_m =
        (half_per_sigma * nd.eigenvalues_m2.cwiseSqrt()).cwiseMax(0.1).cwiseMin(0.4);
    patches.push_back(
        {nd.mean_m, half_m[0] * nd.eigenvectors.col(0), half_m[1] * nd.eigenvectors.col(1)});
  }
  return patches;
}

std::vector<SolidBox> occupied_boxes(const SurfacePoints& points, double leaf_m) {
  std::set<CellKey> leaves;
  for (const Eigen::Vector3d& point_m : points.points_m) leaves.insert(cell_key(point_m, leaf_m));
  std::vector<SolidBox> boxes;
  for (const CellKey& key : leaves) {
    const Eigen::Vector3d low_m = leaf_m * Eigen::Vector3d(key.x, key.y, key.z);
    boxes.push_back({low_m, low_m.array() + leaf_m});
  }
  return boxes;
}

std::vector<SolidEllipsoid> nd_solids(const SurfacePoints& points, double cell_m, double sigmas) {
  std::vector<SolidEllipsoid> solids;
  for (const Nd& nd : cells_of(points, cell_m).nds) {
    const Eigen::Vector3d radii_m = (sigmas * nd.eigenvalues_m2.cwiseSqrt()).cwiseMax(0.01);
    const Eigen::Matrix3d axes_m = nd.eigenvectors * radii_m.asDiagonal();
    solids.push_back({nd.mean_m, radii_m.cwiseInverse().asDiagonal() * nd.eigenvectors.transpose(),
                      axes_m.rowwise().norm()});
  }
  return solids;
}

struct Fit {
  double rays = 0.0;
  double agreements = 0.0;
  std::vector<double> error_m;

  void add(double exact_m, double found_m) {
    const bool is_hit = std::isfinite(exact_m);
    const bool is_found = std::isfinite(found_m);
    rays += 1.0;
    agreements += is_hit == is_found ? 1.0 : 0.0;
    if (is_hit && is_found) error_m.push_back(std::abs(found_m - exact_m));
  }
};

struct Tally {
  const char* name = "";
  std::function<std::unique_ptr<ShapeScene>(const SurfacePoints&, std::size_t&)> make;
  std::size_t primitives = 0;
  double build_s = 0.0;
  double cast_s = 0.0;
  Fit fit;
  std::array<Fit, kBands> bands;  // of the last town
};

void tally(const std::vector<double>& exact_m, const std::vector<float>& found_m, Tally& row) {
  for (std::size_t i = 0; i < exact_m.size(); ++i) {
    const std::size_t band = std::min(i / kColumns / kBandRows, kBands - 1);
    row.fit.add(exact_m[i], static_cast<double>(found_m[i]));
    row.bands[band].add(exact_m[i], static_cast<double>(found_m[i]));
  }
}

double quantile(std::vector<double>& values, double share) {
  if (values.empty()) return 0.0;
  const auto at = static_cast<long>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

template <class Shapes, class Make>
auto shape(Shapes shapes_of, Make make) {
  return [=](const SurfacePoints& points, std::size_t& count) {
    auto shapes = shapes_of(points);
    count += shapes.size();
    return make(std::move(shapes));
  };
}

std::vector<Tally> candidates() {
  const auto squares = [](double share) {
    return [share](const SurfacePoints& points) { return solid_squares(points, share); };
  };
  const auto rectangle = [](double sigmas) {
    return [sigmas](const SurfacePoints& points) { return rectangles(points, sigmas); };
  };
  const auto boxes = [](double leaf_m) {
    return [leaf_m](const SurfacePoints& points) { return occupied_boxes(points, leaf_m); };
  };
  const auto solids = [](double cell_m, double sigmas) {
    return [=](const SurfacePoints& points) { return nd_solids(points, cell_m, sigmas); };
  };
  std::vector<Tally> rows;
  const auto add = [&](const char* name, auto make) {
    Tally row;
    row.name = name;
    row.make = make;
    rows.push_back(std::move(row));
  };
  add("squares (surface v2)", shape(squares(1.0), ShapeScene::of_quadrangles));
  add("squares, sides 0.9", shape(squares(0.9), ShapeScene::of_quadrangles));
  add("squares, sides 1.1", shape(squares(1.1), ShapeScene::of_quadrangles));
  // 2 / sqrt(pi): discs of the same area.
  add("discs of equal area", shape(squares(std::numbers::inv_sqrtpi * 2.0), ShapeScene::of_discs));
  add("rectangles, 1.7 sigma", shape(rectangle(1.7), ShapeScene::of_quadrangles));
  add("rectangles, 2.2 sigma", shape(rectangle(2.2), ShapeScene::of_quadrangles));
  add("occupied leaves, 0.2 m", shape(boxes(0.2), ShapeScene::of_boxes));
  add("occupied leaves, 0.4 m", shape(boxes(0.4), ShapeScene::of_boxes));
  add("ND solids, 0.5 m, 2 sigma", shape(solids(0.5, 2.0), ShapeScene::of_ellipsoids));
  add("ND solids, 2.0 m, 2 sigma", shape(solids(2.0, 2.0), ShapeScene::of_ellipsoids));
  return rows;
}

void compare(const Views& views, std::vector<Tally>& rows) {
  const std::vector<Eigen::Vector3f> directions = image_directions();
  std::vector<std::unique_ptr<ShapeScene>> scenes;
  for (Tally& row : rows) {
    const double begin_s = 1e-3 * thread_cpu_ms();
    scenes.push_back(row.make(views.points, row.primitives));
    row.build_s += 1e-3 * thread_cpu_ms() - begin_s;
  }
  std::vector<float> found_m(directions.size());
  for (std::size_t site = 0; site < views.sites_m.size(); ++site) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const double begin_s = 1e-3 * thread_cpu_ms();
      scenes[i]->cast(views.sites_m[site], directions, found_m);
      rows[i].cast_s += 1e-3 * thread_cpu_ms() - begin_s;
      tally(views.exact_m[site], found_m, rows[i]);
    }
  }
}

void print(const char* name, Fit& fit) {
  std::printf("%-28s %9.2f %9.1f %8.1f", name, 100.0 * fit.agreements / fit.rays,
              100.0 * quantile(fit.error_m, 0.5), 100.0 * quantile(fit.error_m, 0.95));
}

void print_bands(std::uint64_t seed, Tally& row) {
  std::printf("town %llu, %s\n%-28s %9s %9s %8s\n", static_cast<unsigned long long>(seed), row.name,
              "elevations (degrees)", "agree %", "median cm", "p95 cm");
  for (std::size_t band = 0; band < kBands; ++band) {
    char name[32];
    const int first_deg = static_cast<int>(band) * kBandRows - 15;
    std::snprintf(name, sizeof name, "%d .. %d", first_deg,
                  band + 1 == kBands ? 15 : first_deg + kBandRows - 1);
    print(name, row.bands[band]);
    std::printf("\n");
    row.bands[band] = {};
  }
}

void print(std::vector<Tally>& rows) {
  std::printf("%-28s %9s %9s %8s %10s %8s %9s\n", "shape", "agree %", "median cm", "p95 cm",
              "primitives", "Mrays/s", "made in s");
  for (Tally& row : rows) {
    print(row.name, row.fit);
    std::printf(" %10zu %8.2f %9.2f\n", row.primitives, row.fit.rays / row.cast_s / 1e6,
                row.build_s);
  }
}

}  // namespace
}  // namespace sightline

int main(int argc, char** argv) {
  using namespace sightline;
  const double length_m = argc > 1 ? std::strtod(argv[1], nullptr) : 150.0;
  std::vector<Tally> rows = candidates();
  for (int i = 2; i < std::max(argc, 3); ++i) {
    const std::uint64_t seed = i < argc ? std::strtoull(argv[i], nullptr, 10) : 1;
    compare(drive_through(seed, length_m), rows);
    print_bands(seed, rows.front());
  }
  print(rows);
  return 0;
}
