#include "tests/support/lane/lane_caster.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "formats/base/check.h"
#include "formats/base/parallel.h"
#include "formats/base/random.h"
#include "formats/geometry.h"
#include "passes/rays/embree.h"

namespace sightline::lane {

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
