#include "examples/town/drive/caster.h"

#include <algorithm>
#include <cmath>

#include "formats/base/check.h"
#include "passes/rays/embree.h"

// Embree's tree of boxes proposes triangles, in float; which of them a ray meets, and where, is
// decided here in double, so that a town is recorded with the same bits on every processor.

namespace sightline::town {
namespace {

struct Triangle {
  Eigen::Vector3d a, ab, ac, normal;
  Eigen::Vector3f low_m, high_m;  // its box
};

Triangle triangle_of(const TownMesh& mesh, const std::array<std::uint32_t, 3>& corners) {
  const Eigen::Vector3f& a = mesh.vertices_m[corners[0]];
  const Eigen::Vector3f& b = mesh.vertices_m[corners[1]];
  const Eigen::Vector3f& c = mesh.vertices_m[corners[2]];
  const Eigen::Vector3d ab = b.cast<double>() - a.cast<double>();
  const Eigen::Vector3d ac = c.cast<double>() - a.cast<double>();
  return {a.cast<double>(),         ab, ac, ab.cross(ac), a.cwiseMin(b).cwiseMin(c),
          a.cwiseMax(b).cwiseMax(c)};
}

// What the triangles of a scene are to Embree.
struct Shape {
  std::vector<Triangle> triangles;
  float margin_m = 0.0F;  // how far a ray may be off once its numbers are floats
};

Shape shape_of(const TownMesh& mesh) {
  Shape shape;
  float farthest_m = 0.0F;
  for (const std::array<std::uint32_t, 3>& corners : mesh.triangles) {
    shape.triangles.push_back(triangle_of(mesh, corners));
    const Triangle& triangle = shape.triangles.back();
    farthest_m = std::max(
        {farthest_m, triangle.low_m.cwiseAbs().maxCoeff(), triangle.high_m.cwiseAbs().maxCoeff()});
  }
  shape.margin_m = 1e-3F + 1e-6F * farthest_m;
  return shape;
}

// One ray, and the nearest triangle that it meets.
struct ExactCast : EmbreeContext {
  Eigen::Vector3d origin_m;
  Eigen::Vector3d direction;
  double range_m = std::numeric_limits<double>::infinity();
  std::uint32_t triangle = 0;
};

// Moeller and Trumbore (1997); infinity where the ray passes by, or sees the triangle edge-on.
double range_to_m(const Triangle& triangle, const ExactCast& ray) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const Eigen::Vector3d p = ray.direction.cross(triangle.ac);
  const double determinant = triangle.ab.dot(p);
  const double along = triangle.normal.dot(ray.direction);
  if (determinant == 0.0 || along == 0.0) return kNone;
  const Eigen::Vector3d offset_m = ray.origin_m - triangle.a;
  const double u = offset_m.dot(p) / determinant;
  if (!(u >= 0.0 && u <= 1.0)) return kNone;
  const double v = ray.direction.dot(offset_m.cross(triangle.ab)) / determinant;
  if (!(v >= 0.0 && u + v <= 1.0)) return kNone;
  const double range_m = triangle.normal.dot(triangle.a - ray.origin_m) / along;
  return range_m >= 0.0 ? range_m : kNone;
}

void box_of_triangle(const RTCBoundsFunctionArguments* call) {
  const auto& shape = *static_cast<const Shape*>(call->geometryUserPtr);
  const Triangle& triangle = shape.triangles[call->primID];
  RTCBounds& box = *call->bounds_o;
  box.lower_x = triangle.low_m.x() - shape.margin_m;
  box.lower_y = triangle.low_m.y() - shape.margin_m;
  box.lower_z = triangle.low_m.z() - shape.margin_m;
  box.upper_x = triangle.high_m.x() + shape.margin_m;
  box.upper_y = triangle.high_m.y() + shape.margin_m;
  box.upper_z = triangle.high_m.z() + shape.margin_m;
}

void intersect_triangle(const RTCIntersectFunctionNArguments* call) {
  SIGHTLINE_CHECK(call->N == 1);
  if (call->valid[0] != -1) return;
  const auto& shape = *static_cast<const Shape*>(call->geometryUserPtr);
  auto& cast = *static_cast<ExactCast*>(call->context);
  const double range_m = range_to_m(shape.triangles[call->primID], cast);
  const bool is_nearer =
      range_m < cast.range_m || (range_m == cast.range_m && call->primID < cast.triangle &&
                                 range_m < std::numeric_limits<double>::infinity());
  if (!is_nearer) return;
  cast.range_m = range_m;
  cast.triangle = call->primID;
  RTCRayN* ray = RTCRayHitN_RayN(call->rayhit, 1);
  RTCRayN_tfar(ray, 1, 0) = static_cast<float>(range_m) + shape.margin_m;
}

// Ericson, Real-Time Collision Detection (2005), 5.1.5, by the regions of a triangle's plane.
Eigen::Vector3d nearest_point_m(const Triangle& triangle, const Eigen::Vector3d& point_m) {
  const Eigen::Vector3d& ab = triangle.ab;
  const Eigen::Vector3d& ac = triangle.ac;
  const Eigen::Vector3d ap = point_m - triangle.a;
  const double d1 = ab.dot(ap);
  const double d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return triangle.a;
  const Eigen::Vector3d bp = ap - ab;
  const double d3 = ab.dot(bp);
  const double d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return triangle.a + ab;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return triangle.a + d1 / (d1 - d3) * ab;
  const Eigen::Vector3d cp = ap - ac;
  const double d5 = ab.dot(cp);
  const double d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return triangle.a + ac;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return triangle.a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
    return triangle.a + ab + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (ac - ab);
  }
  const double sum = va + vb + vc;
  return triangle.a + vb / sum * ab + vc / sum * ac;
}

// A search for the triangle that is nearest to a point.
struct NearestSearch {
  const Shape& shape;
  Eigen::Vector3d point_m;
  double distance_m = 0.0;
  std::uint32_t triangle = RTC_INVALID_GEOMETRY_ID;
  Eigen::Vector3d nearest_m = Eigen::Vector3d::Zero();
};

bool approach_triangle(RTCPointQueryFunctionArguments* call) {
  auto& search = *static_cast<NearestSearch*>(call->userPtr);
  const Triangle& triangle = search.shape.triangles[call->primID];
  if (triangle.normal.squaredNorm() == 0.0) return false;
  const Eigen::Vector3d nearest_m = nearest_point_m(triangle, search.point_m);
  const double distance_m = (nearest_m - search.point_m).norm();
  const bool is_nearer = distance_m < search.distance_m ||
                         (distance_m == search.distance_m && call->primID < search.triangle);
  if (!is_nearer) return false;
  search.distance_m = distance_m;
  search.triangle = call->primID;
  search.nearest_m = nearest_m;
  call->query->radius = static_cast<float>(distance_m) + search.shape.margin_m;
  return true;
}

// One device for the process: making one takes milliseconds, and each scan makes a small scene.
RTCDevice shared_device() {
  static const RTCDevice device = rtcNewDevice("");
  SIGHTLINE_CHECK(device != nullptr);
  return device;
}

RTCScene make_scene(Shape& shape) {
  const RTCDevice device = shared_device();
  const RTCScene scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);  // boxes are not missed for rounding
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(shape.triangles.size()));
  rtcSetGeometryUserData(geometry, &shape);
  rtcSetGeometryBoundsFunction(geometry, &box_of_triangle, nullptr);
  rtcSetGeometryIntersectFunction(geometry, &intersect_triangle);
  rtcSetGeometryPointQueryFunction(geometry, &approach_triangle);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  SIGHTLINE_CHECK(rtcGetDeviceError(device) == RTC_ERROR_NONE);
  return scene;
}

}  // namespace

struct TownCaster::State {
  explicit State(const TownMesh& mesh)
      : shape(shape_of(mesh)), labels(mesh.labels), scene(make_scene(shape)) {}
  Shape shape;
  std::vector<Label> labels;
  RTCScene scene;
};

TownCaster::TownCaster(const TownMesh& mesh) : state_(new State(mesh)) {}

TownCaster::~TownCaster() { rtcReleaseScene(state_->scene); }

Hit TownCaster::cast(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction) const {
  ExactCast cast;
  start_query(cast);
  cast.origin_m = origin_m;
  cast.direction = direction;
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
  intersect_1(state_->scene, cast, query);
  if (!(cast.range_m < std::numeric_limits<double>::infinity())) return {};
  const Eigen::Vector3d& normal = state_->shape.triangles[cast.triangle].normal;
  return {cast.range_m, std::abs(normal.dot(direction)) / normal.norm(),
          state_->labels[cast.triangle]};
}

Surface TownCaster::nearest_surface(const Eigen::Vector3d& point_m, double within_m) const {
  NearestSearch search{state_->shape, point_m, within_m};
  RTCPointQuery query{};
  query.x = static_cast<float>(point_m.x());
  query.y = static_cast<float>(point_m.y());
  query.z = static_cast<float>(point_m.z());
  query.radius = static_cast<float>(within_m) + state_->shape.margin_m;
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(state_->scene, &query, &context, nullptr, &search);
  if (search.triangle == RTC_INVALID_GEOMETRY_ID) return {};
  return {true, search.nearest_m, state_->shape.triangles[search.triangle].normal.normalized()};
}

}  // namespace sightline::town
