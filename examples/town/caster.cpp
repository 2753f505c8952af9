#include "examples/town/caster.h"

#include <embree3/rtcore.h>

#include <cmath>
#include <cstring>

#include "compiler/base/check.h"

namespace sightline::town {
namespace {

// One device for the process: making one takes milliseconds, and each scan makes a small scene.
// Pinned to one instruction set because the last bits of a hit differ between them.
RTCDevice shared_device() {
  static const RTCDevice device = rtcNewDevice("max_isa=avx2");
  SIGHTLINE_CHECK(device != nullptr);
  return device;
}

RTCScene make_scene(const TownMesh& mesh) {
  const RTCDevice device = shared_device();
  const RTCScene scene = rtcNewScene(device);
  // Robust: no ray slips between two triangles that share an edge.
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                           sizeof(Eigen::Vector3f), mesh.vertices_m.size());
  void* triangles = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                            3 * sizeof(std::uint32_t), mesh.triangles.size());
  SIGHTLINE_CHECK(mesh.triangles.empty() || (vertices != nullptr && triangles != nullptr));
  if (!mesh.triangles.empty()) {
    std::memcpy(vertices, mesh.vertices_m.data(), mesh.vertices_m.size() * sizeof(Eigen::Vector3f));
    std::memcpy(triangles, mesh.triangles.data(),
                mesh.triangles.size() * 3 * sizeof(std::uint32_t));
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  return scene;
}

}  // namespace

struct TownCaster::State {
  TownMesh mesh;
  RTCScene scene;
};

TownCaster::TownCaster(const TownMesh& mesh) : state_(new State{mesh, make_scene(mesh)}) {}

TownCaster::~TownCaster() { rtcReleaseScene(state_->scene); }

Hit TownCaster::cast(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction) const {
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
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(state_->scene, &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};

  const std::array<std::uint32_t, 3>& triangle = state_->mesh.triangles[query.hit.primID];
  const Eigen::Vector3d a = state_->mesh.vertices_m[triangle[0]].cast<double>();
  const Eigen::Vector3d b = state_->mesh.vertices_m[triangle[1]].cast<double>();
  const Eigen::Vector3d c = state_->mesh.vertices_m[triangle[2]].cast<double>();
  const Eigen::Vector3d normal = (b - a).cross(c - a);
  const double along = normal.dot(direction);
  if (along == 0.0) return {};  // seen edge-on: the tree's float arithmetic found a hit, we do not
  return {normal.dot(a - origin_m) / along, std::abs(along) / normal.norm(),
          state_->mesh.labels[query.hit.primID]};
}

}  // namespace sightline::town
