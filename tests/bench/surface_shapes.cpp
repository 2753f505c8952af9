#include "tests/bench/surface_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "formats/base/check.h"
#include "passes/rays/embree.h"

namespace sightline {
namespace {

constexpr float kNear_m = 0.5F;
constexpr float kFar_m = 50.0F;
constexpr std::size_t kPacket = 8;

RTCDevice device() {
  static const RTCDevice kDevice = rtcNewDevice("max_isa=avx2,set_affinity=0");
  SIGHTLINE_CHECK(kDevice != nullptr);
  return kDevice;
}

template <class T, int kRows>
T* new_buffer(RTCGeometry geometry, RTCBufferType type, RTCFormat format, std::size_t count) {
  return static_cast<T*>(
      rtcSetNewGeometryBuffer(geometry, type, 0, format, kRows * sizeof(T), count));
}

struct Lane {
  Eigen::Vector3f origin_m;
  Eigen::Vector3f direction;
  float near_m = 0.0F;
  float far_m = 0.0F;
};

Lane lane_of(RTCRayN* rays, unsigned size, unsigned i) {
  return {
      {RTCRayN_org_x(rays, size, i), RTCRayN_org_y(rays, size, i), RTCRayN_org_z(rays, size, i)},
      {RTCRayN_dir_x(rays, size, i), RTCRayN_dir_y(rays, size, i), RTCRayN_dir_z(rays, size, i)},
      RTCRayN_tnear(rays, size, i),
      RTCRayN_tfar(rays, size, i)};
}

// Where a line enters and leaves a shape; the first of the two within the ray's limits counts.
float first_within(float enter_m, float leave_m, const Lane& lane) {
  if (!(enter_m <= leave_m)) return std::numeric_limits<float>::infinity();
  if (enter_m >= lane.near_m && enter_m <= lane.far_m) return enter_m;
  if (leave_m >= lane.near_m && leave_m <= lane.far_m) return leave_m;
  return std::numeric_limits<float>::infinity();
}

float hit(const SolidBox& box, const Lane& lane) {
  float enter_m = -std::numeric_limits<float>::infinity();
  float leave_m = std::numeric_limits<float>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const float a =
        (static_cast<float>(box.low_m[axis]) - lane.origin_m[axis]) / lane.direction[axis];
    const float b =
        (static_cast<float>(box.high_m[axis]) - lane.origin_m[axis]) / lane.direction[axis];
    enter_m = std::max(enter_m, std::min(a, b));
    leave_m = std::min(leave_m, std::max(a, b));
  }
  return first_within(enter_m, leave_m, lane);
}

float hit(const SolidEllipsoid& ellipsoid, const Lane& lane) {
  const Eigen::Matrix3f unit_per_m = ellipsoid.unit_per_m.cast<float>();
  const Eigen::Vector3f from =
      unit_per_m * (lane.origin_m - ellipsoid.centre_m.cast<float>()).eval();
  const Eigen::Vector3f along = unit_per_m * lane.direction;
  const float a = along.squaredNorm();
  const float b = along.dot(from);
  // From the point of the line nearest to the centre, so that nothing cancels.
  const Eigen::Vector3f nearest = from - b / a * along;
  const float rest = 1.0F - nearest.squaredNorm();
  if (rest < 0.0F) return std::numeric_limits<float>::infinity();
  const float half_m = std::sqrt(rest / a);
  return first_within(-b / a - half_m, -b / a + half_m, lane);
}

void set_bounds(const SolidBox& box, RTCBounds& bounds) {
  bounds.lower_x = static_cast<float>(box.low_m.x());
  bounds.lower_y = static_cast<float>(box.low_m.y());
  bounds.lower_z = static_cast<float>(box.low_m.z());
  bounds.upper_x = static_cast<float>(box.high_m.x());
  bounds.upper_y = static_cast<float>(box.high_m.y());
  bounds.upper_z = static_cast<float>(box.high_m.z());
}

void set_bounds(const SolidEllipsoid& ellipsoid, RTCBounds& bounds) {
  set_bounds(
      SolidBox{ellipsoid.centre_m - ellipsoid.reach_m, ellipsoid.centre_m + ellipsoid.reach_m},
      bounds);
}

template <class Solid>
void intersect_solid(const RTCIntersectFunctionNArguments* call) {
  const Solid& solid = static_cast<const Solid*>(call->geometryUserPtr)[call->primID];
  RTCRayN* rays = RTCRayHitN_RayN(call->rayhit, call->N);
  RTCHitN* hits = RTCRayHitN_HitN(call->rayhit, call->N);
  for (unsigned i = 0; i < call->N; ++i) {
    if (call->valid[i] == 0) continue;
    const float distance_m = hit(solid, lane_of(rays, call->N, i));
    if (!std::isfinite(distance_m)) continue;
    RTCRayN_tfar(rays, call->N, i) = distance_m;
    RTCHitN_geomID(hits, call->N, i) = call->geomID;
    RTCHitN_primID(hits, call->N, i) = call->primID;
  }
}

template <class Solid>
RTCGeometry solid_geometry(std::vector<Solid>& solids) {
  const RTCGeometry geometry = rtcNewGeometry(device(), RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(solids.size()));
  rtcSetGeometryUserData(geometry, solids.data());
  rtcSetGeometryBoundsFunction(
      geometry,
      [](const RTCBoundsFunctionArguments* call) {
        set_bounds(static_cast<const Solid*>(call->geometryUserPtr)[call->primID], *call->bounds_o);
      },
      nullptr);
  rtcSetGeometryIntersectFunction(geometry, intersect_solid<Solid>);
  return geometry;
}

void fill(const Eigen::Vector3f& origin_m, std::span<const Eigen::Vector3f> directions,
          RTCRayHit8& packet) {
  for (std::size_t lane = 0; lane < kPacket; ++lane) {
    const Eigen::Vector3f& direction = directions[std::min(lane, directions.size() - 1)];
    packet.ray.org_x[lane] = origin_m.x();
    packet.ray.org_y[lane] = origin_m.y();
    packet.ray.org_z[lane] = origin_m.z();
    packet.ray.dir_x[lane] = direction.x();
    packet.ray.dir_y[lane] = direction.y();
    packet.ray.dir_z[lane] = direction.z();
    packet.ray.tnear[lane] = kNear_m;
    packet.ray.tfar[lane] = kFar_m;
    packet.ray.time[lane] = 0.0F;
    packet.ray.mask[lane] = ~0U;
    packet.ray.flags[lane] = 0;
    packet.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
    packet.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
  }
}

}  // namespace

struct ShapeScene::State {
  std::vector<SolidBox> boxes;
  std::vector<SolidEllipsoid> ellipsoids;
  RTCScene scene = rtcNewScene(device());

  void commit(RTCGeometry geometry) {
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    SIGHTLINE_CHECK(rtcGetDeviceError(device()) == RTC_ERROR_NONE);
  }
};

ShapeScene::ShapeScene(std::unique_ptr<State> state) : state_(std::move(state)) {}

ShapeScene::~ShapeScene() { rtcReleaseScene(state_->scene); }

std::unique_ptr<ShapeScene> ShapeScene::of_discs(std::span<const FlatPatch> patches) {
  const RTCGeometry geometry = rtcNewGeometry(device(), RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT);
  float* vertices =
      new_buffer<float, 4>(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, patches.size());
  float* normals =
      new_buffer<float, 3>(geometry, RTC_BUFFER_TYPE_NORMAL, RTC_FORMAT_FLOAT3, patches.size());
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const FlatPatch& patch = patches[i];
    const Eigen::Vector3f centre_m = patch.centre_m.cast<float>();
    const Eigen::Vector3f normal = patch.half_u_m.cross(patch.half_v_m).normalized().cast<float>();
    std::copy_n(centre_m.data(), 3, vertices + 4 * i);
    vertices[4 * i + 3] =
        static_cast<float>(std::min(patch.half_u_m.norm(), patch.half_v_m.norm()));
    std::copy_n(normal.data(), 3, normals + 3 * i);
  }
  auto state = std::make_unique<State>();
  state->commit(geometry);
  return std::unique_ptr<ShapeScene>(new ShapeScene(std::move(state)));
}

std::unique_ptr<ShapeScene> ShapeScene::of_quadrangles(std::span<const FlatPatch> patches) {
  const RTCGeometry geometry = rtcNewGeometry(device(), RTC_GEOMETRY_TYPE_QUAD);
  float* vertices =
      new_buffer<float, 3>(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, 4 * patches.size());
  auto* corners = new_buffer<std::uint32_t, 4>(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT4,
                                               patches.size());
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const FlatPatch& patch = patches[i];
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const double u = corner == 0 || corner == 3 ? -1.0 : 1.0;
      const double v = corner < 2 ? -1.0 : 1.0;
      const Eigen::Vector3d at_m = patch.centre_m + u * patch.half_u_m + v * patch.half_v_m;
      const Eigen::Vector3f at = at_m.cast<float>();
      std::copy_n(at.data(), 3, vertices + 3 * (4 * i + corner));
      corners[4 * i + corner] = static_cast<std::uint32_t>(4 * i + corner);
    }
  }
  auto state = std::make_unique<State>();
  state->commit(geometry);
  return std::unique_ptr<ShapeScene>(new ShapeScene(std::move(state)));
}

std::unique_ptr<ShapeScene> ShapeScene::of_boxes(std::vector<SolidBox> boxes) {
  auto state = std::make_unique<State>();
  state->boxes = std::move(boxes);
  state->commit(solid_geometry(state->boxes));
  return std::unique_ptr<ShapeScene>(new ShapeScene(std::move(state)));
}

std::unique_ptr<ShapeScene> ShapeScene::of_ellipsoids(std::vector<SolidEllipsoid> ellipsoids) {
  auto state = std::make_unique<State>();
  state->ellipsoids = std::move(ellipsoids);
  state->commit(solid_geometry(state->ellipsoids));
  return std::unique_ptr<ShapeScene>(new ShapeScene(std::move(state)));
}

void ShapeScene::cast(const Eigen::Vector3d& p_m, std::span<const Eigen::Vector3f> directions,
                      std::span<float> distance_m) const {
  const Eigen::Vector3f origin_m = p_m.cast<float>();
  EmbreeContext context;
  start_query(context);
  RTCRayHit8 packet;
  for (std::size_t first = 0; first < directions.size(); first += kPacket) {
    const std::size_t count = std::min(kPacket, directions.size() - first);
    alignas(32) std::array<int, kPacket> valid;
    for (std::size_t lane = 0; lane < kPacket; ++lane) valid[lane] = lane < count ? -1 : 0;
    fill(origin_m, directions.subspan(first, count), packet);
    intersect_8(valid.data(), state_->scene, context, EmbreeRays::kAnyWay, packet);
    for (std::size_t lane = 0; lane < count; ++lane) {
      const bool is_hit = packet.hit.geomID[lane] != RTC_INVALID_GEOMETRY_ID;
      distance_m[first + lane] =
          is_hit ? packet.ray.tfar[lane] : std::numeric_limits<float>::infinity();
    }
  }
}

}  // namespace sightline
