#include "tests/support/lane/lane.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "formats/base/check.h"
#include "formats/base/parallel.h"
#include "formats/base/random.h"
#include "formats/geometry.h"
#include "passes/rays/embree.h"
#include "tests/support/lane/roadside.h"

namespace sightline::lane {
namespace {

constexpr double kBeyond_m = 70.0;  // what is seen from the ends of the drive
constexpr double kCrossing_m = 14.0;

double line_x_m(double y_m) { return 1.5 * std::sin(y_m / 25.0); }

void add_ground(Lane& lane, double length_m) {
  const auto corner = [&](int x, int y) {
    return Eigen::Vector3d(x, y, lane.ground.height_m(x, y));
  };
  const int end = static_cast<int>(length_m + kBeyond_m);
  for (int x = -80; x < 80; ++x) {
    for (int y = -static_cast<int>(kBeyond_m); y < end; ++y) {
      add_quad(lane.mesh, {corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)},
               Kind::kGround);
    }
  }
}

void add_car(Lane& lane, const Eigen::Vector2d& at_m, Random& random) {
  const double yaw_rad = 1.5707 + random.uniform(-0.05, 0.05);
  const double ground = lane.ground.height_m(at_m.x(), at_m.y());
  const double length_m = random.uniform(1.9, 2.4);
  add_rounded(lane.mesh, {{at_m.x(), at_m.y(), ground + 0.62}, {length_m, 0.88, 0.42}, yaw_rad},
              0.35, Kind::kCar);
  add_rounded(lane.mesh,
              {{at_m.x(), at_m.y() - 0.2, ground + 1.05}, {0.6 * length_m, 0.75, 0.45}, yaw_rad},
              0.6, Kind::kCar);
}

void add_sign(Lane& lane, const Eigen::Vector2d& at_m, Random& random) {
  const Eigen::Vector3d foot_m(at_m.x(), at_m.y(), lane.ground.height_m(at_m.x(), at_m.y()));
  add_tube(lane.mesh, {foot_m, foot_m + Eigen::Vector3d(0.0, 0.0, 2.8), 0.03}, Kind::kPole);
  add_block(
      lane.mesh,
      {foot_m + Eigen::Vector3d(0.0, -0.05, 2.5), {0.3, 0.01, 0.3}, random.uniform(-0.4, 0.4)},
      Kind::kSign);
}

void add_lamp(Lane& lane, const Eigen::Vector2d& at_m, double towards) {
  const Eigen::Vector3d foot_m(at_m.x(), at_m.y(), lane.ground.height_m(at_m.x(), at_m.y()));
  const Eigen::Vector3d top_m = foot_m + Eigen::Vector3d(0.0, 0.0, 6.5);
  add_tube(lane.mesh, {foot_m, top_m, 0.07}, Kind::kPole);
  add_tube(lane.mesh, {top_m, top_m + Eigen::Vector3d(1.5 * towards, 0.0, 0.2), 0.04}, Kind::kPole);
}

void add_furniture(Lane& lane, double side, const LaneOptions& options, Random& random) {
  double y_m = -30.0 + random.uniform(0.0, 5.0);
  while (y_m < options.length_m + 30.0) {
    const double kerb_m = line_x_m(y_m) + side * 3.6;
    const double what = random.uniform();
    if (what < 0.40) add_car(lane, {kerb_m, y_m}, random);
    if (what >= 0.40 && what < 0.55) add_sign(lane, {kerb_m + 0.8 * side, y_m}, random);
    if (what >= 0.55 && what < 0.70) add_lamp(lane, {kerb_m + 0.9 * side, y_m}, -side);
    if (what >= 0.70) {
      const Eigen::Vector2d at_m(kerb_m + 1.3 * side, y_m);
      add_tree(lane, at_m, options.has_leaves, random);
    }
    y_m += random.uniform(4.5, 8.0);
  }
}

void add_row(Lane& lane, double side, const LaneOptions& options, Random& random) {
  const double crossing_m = 0.6 * options.length_m;
  double y_m = -60.0;
  while (y_m < options.length_m + 60.0) {
    House house = draw_house(side, y_m, random);
    const bool is_crossing = house.to_y_m > crossing_m && house.from_y_m < crossing_m + kCrossing_m;
    y_m = is_crossing ? crossing_m + kCrossing_m : house.to_y_m + random.uniform(0.5, 6.0);
    if (is_crossing) continue;
    const double middle_m = 0.5 * (house.from_y_m + house.to_y_m);
    add_house(lane.mesh, house, lane.ground.height_m(side * house.front_m, middle_m));
    if (house.front_m < 8.0) continue;
    const Border border{side * (house.front_m - 2.5), house.from_y_m, house.to_y_m};
    if (random.uniform() < 0.5) {
      add_fence(lane, border);
    } else if (options.has_leaves) {
      add_hedge(lane, border, random);
    }
  }
}

void add_background(Lane& lane, double side, double length_m, Random& random) {
  for (double y_m = -60.0; y_m < length_m + 60.0; y_m += random.uniform(14.0, 30.0)) {
    const double half_m = random.uniform(3.0, 9.0);
    const double x_m = side * random.uniform(32.0, 55.0);
    const double height_m = random.uniform(3.0, 9.0);
    add_block(lane.mesh,
              {{x_m, y_m, lane.ground.height_m(x_m, y_m) + 0.5 * height_m - 1.0},
               {half_m, 0.7 * half_m, 0.5 * height_m + 1.0},
               random.uniform(-0.6, 0.6)},
              Kind::kWall);
  }
}

}  // namespace

double Ground::height_m(double x_m, double y_m) const {
  const double waves_m = 0.5 * std::sin(y_m / 19.0 + 0.3) + 0.2 * std::sin(x_m / 9.0 + y_m / 31.0) +
                         0.05 * std::sin(x_m / 2.1) * std::sin(y_m / 2.7);
  return 50.0 + hills * waves_m;
}

Pose sensor_pose(const Ground& ground, double way_m) {
  constexpr double kAhead_m = 1.5;
  const auto on_line = [&](double y_m) {
    return Eigen::Vector3d(line_x_m(y_m), y_m, ground.height_m(line_x_m(y_m), y_m) + 2.0);
  };
  const Eigen::Vector3d forward =
      (on_line(way_m + kAhead_m) - on_line(way_m - kAhead_m)).normalized();
  const Eigen::Vector3d left = Eigen::Vector3d::UnitZ().cross(forward).normalized();
  Pose pose = Pose::Identity();
  pose.linear() << forward, left, forward.cross(left);
  pose.translation() = on_line(way_m);
  return pose;
}

Lane make_lane(const LaneOptions& options) {
  Lane lane;
  lane.ground.hills = options.hills;
  add_ground(lane, options.length_m);
  for (const double side : {-1.0, 1.0}) {
    Random random(mix(options.seed, side > 0.0 ? 2 : 1));
    add_row(lane, side, options, random);
    add_background(lane, side, options.length_m, random);
    Random furniture(mix(options.seed, side > 0.0 ? 4 : 3));
    add_furniture(lane, side, options, furniture);
  }
  return lane;
}

struct Caster::State {
  RTCDevice device = rtcNewDevice("set_affinity=0");
  RTCScene scene = rtcNewScene(device);
  std::vector<Kind> kinds;

  explicit State(const Mesh& mesh) : kinds(mesh.kinds) {
    const std::size_t count = mesh.triangles_m.size();
    const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), 3 * count));
    auto* corners = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), count));
    SIGHTLINE_CHECK(vertices != nullptr && corners != nullptr);
    for (std::size_t i = 0; i < 3 * count; ++i) {
      const Eigen::Vector3f corner_m = mesh.triangles_m[i / 3][i % 3].cast<float>();
      std::copy_n(corner_m.data(), 3, vertices + 3 * i);
      corners[i] = static_cast<unsigned>(i);
    }
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
  }
  ~State() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;
};

Caster::Caster(const Mesh& mesh) : state_(std::make_unique<State>(mesh)) {}
Caster::~Caster() = default;

Hit Caster::cast(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction) const {
  RTCRayHit query{};
  query.ray.org_x = static_cast<float>(origin_m.x());
  query.ray.org_y = static_cast<float>(origin_m.y());
  query.ray.org_z = static_cast<float>(origin_m.z());
  query.ray.dir_x = static_cast<float>(direction.x());
  query.ray.dir_y = static_cast<float>(direction.y());
  query.ray.dir_z = static_cast<float>(direction.z());
  query.ray.tfar = std::numeric_limits<float>::infinity();
  query.ray.mask = ~0U;
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  EmbreeContext context;
  start_query(context);
  intersect_1(state_->scene, context, query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  return {static_cast<double>(query.ray.tfar), state_->kinds[query.hit.primID]};
}

namespace {

Scan spin(const Caster& caster, const DriveOptions& options, const Pose& T_map_lidar,
          Random& random) {
  Scan scan;
  const SensorProfile& sensor = options.sensor;
  const auto columns = static_cast<int>(std::lround(360.0 / sensor.azimuth_step_deg));
  // The first column points anywhere: real sensors do not fire at the same angles every turn.
  const double first_rad = random.uniform(0.0, 2.0 * std::numbers::pi / columns);
  for (int column = 0; column < columns; ++column) {
    const double azimuth_rad = first_rad + 2.0 * std::numbers::pi * column / columns;
    for (const double elevation_deg : sensor.beam_elevations_deg) {
      const Eigen::Vector3d direction =
          direction_of(azimuth_rad, elevation_deg * std::numbers::pi / 180.0);
      const Hit hit = caster.cast(T_map_lidar.translation(), T_map_lidar.linear() * direction);
      const double range_m = hit.range_m + options.range_sigma_m * random.normal();
      if (range_m < sensor.min_range_m || range_m > sensor.max_range_m) continue;
      scan.points_m.emplace_back(range_m * direction);
    }
  }
  return scan;
}

}  // namespace

SurfacePoints drive_along(const Lane& lane, const Caster& caster, const DriveOptions& options) {
  const auto count = static_cast<std::size_t>(options.length_m / options.spacing_m) + 1;
  std::vector<Scan> scans(count);
  SurfacePoints points;
  points.scans.resize(count);
  parallel_for(count, options.threads, [&](std::size_t i) {
    Random random(mix(options.seed, i));
    const Pose T_map_lidar = sensor_pose(lane.ground, static_cast<double>(i) * options.spacing_m);
    scans[i] = spin(caster, options, T_map_lidar, random);
    points.scans[i] = {static_cast<std::uint32_t>(i), T_map_lidar, options.sensor.min_range_m,
                       options.sensor.max_range_m};
  });
  for (const Scan& scan : scans) points.standing_count += scan.points_m.size();
  points.store = memory_scan_store(std::move(scans));
  return points;
}

}  // namespace sightline::lane
