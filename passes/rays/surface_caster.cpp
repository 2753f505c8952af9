#include "passes/rays/surface_caster.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <new>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>

#include "formats/base/check.h"
#include "formats/base/parallel.h"
#include "formats/base/portable_math.h"
#include "passes/rays/embree.h"
#include "passes/rays/exact_patch.h"

// Embree works in float, and its last bits differ from one instruction set to the next: which rays
// just touch an edge, and which of two patches is the nearer one. So it only proposes: it sees
// patches that are larger by what its arithmetic may be off, and a function of ours that it calls
// for each of them decides in double, from the patch as it is.

namespace sightline {
namespace {

constexpr std::size_t kPacket = 8;  // rays; the width of AVX2

std::atomic<CasterIsa> chosen_isa = CasterIsa::kFastest;

// Configurations by the number of CasterIsa. The fastest: packets are as wide as AVX2's vectors.
constexpr std::array<const char*, 4> kDeviceConfigs = {
    "max_isa=avx2,set_affinity=0", "isa=sse2,set_affinity=0", "isa=avx,set_affinity=0",
    "isa=avx2,set_affinity=0"};

using Device = std::unique_ptr<RTCDeviceTy, decltype(&rtcReleaseDevice)>;
using Scene = std::unique_ptr<RTCSceneTy, decltype(&rtcReleaseScene)>;

// Embree keeps what went wrong in its device, or in the thread where there is no device yet. It has
// no name for threads that cannot be had. Whatever else it says is a mistake of ours.
void check_memory(RTCDevice device) {
  const RTCError error = rtcGetDeviceError(device);
  const bool has_no_threads = device == nullptr && error == RTC_ERROR_UNKNOWN;
  if (error == RTC_ERROR_OUT_OF_MEMORY || has_no_threads) throw std::bad_alloc();
  SIGHTLINE_CHECK(error == RTC_ERROR_NONE);
}

Device make_device() {
  Device device(rtcNewDevice(kDeviceConfigs[static_cast<std::size_t>(chosen_isa.load())]),
                &rtcReleaseDevice);
  check_memory(device.get());
  SIGHTLINE_CHECK(device != nullptr);
  SIGHTLINE_CHECK(
      rtcGetDeviceProperty(device.get(), RTC_DEVICE_PROPERTY_FILTER_FUNCTION_SUPPORTED) == 1);
  return device;
}

// How far Embree's floats may be off where a ray meets a patch: coordinates in a scene reach
// kSiteBlock_m + far_m, a float keeps 2^-24 of them, a slope of kLeastSlope stretches that a
// hundredfold, and a handful of operations add up.
double margin_m(double far_m) { return 5e-5 * (kSiteBlock_m + far_m); }

// Eight rays from anywhere: what differs from site to site is filled in before each use.
struct Packet {
  alignas(32) std::array<int, kPacket> valid;
  RTCRayHit8 rays;
};

std::vector<Packet> packets_of(const RayFan& fan, double margin) {
  const std::size_t ray_count = fan.directions.size();
  std::vector<Packet> packets((ray_count + kPacket - 1) / kPacket);
  for (std::size_t i = 0; i < packets.size() * kPacket; ++i) {
    Packet& packet = packets[i / kPacket];
    const std::size_t lane = i % kPacket;
    const Eigen::Vector3f direction = fan.directions[std::min(i, ray_count - 1)].cast<float>();
    packet.valid[lane] = i < ray_count ? -1 : 0;
    packet.rays.ray.dir_x[lane] = direction.x();
    packet.rays.ray.dir_y[lane] = direction.y();
    packet.rays.ray.dir_z[lane] = direction.z();
    packet.rays.ray.tnear[lane] = static_cast<float>(std::max(0.0, fan.near_m - margin));
    packet.rays.ray.tfar[lane] = static_cast<float>(fan.far_m + margin);
    packet.rays.ray.time[lane] = 0.0F;
    packet.rays.ray.mask[lane] = ~0U;
    packet.rays.ray.id[lane] = static_cast<unsigned>(lane);
    packet.rays.ray.flags[lane] = 0;
    packet.rays.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
    packet.rays.hit.primID[lane] = RTC_INVALID_GEOMETRY_ID;
    packet.rays.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
  }
  return packets;
}

// What a packet is to be compared with in double, and the nearest hit of each of its rays.
struct ExactCast : EmbreeContext {
  std::span<const ExactPatch> patches;
  Eigen::Vector3d p_m;
  std::span<const Eigen::Vector3d> directions;  // of the packet's rays
  double near_m = 0.0;
  double far_m = 0.0;
  double margin_m = 0.0;
  std::array<double, kPacket> distance_m;
};

// Embree calls this for each patch that rays of a packet may meet: it proposes, doubles decide.
// Embree goes on as far as another patch could still be nearer in double, which a filter may ask by
// setting tfar.
void decide_in_double(const RTCFilterFunctionNArguments* call) {
  auto& cast = *static_cast<ExactCast*>(call->context);
  const unsigned count = call->N;
  std::size_t seen_index = cast.patches.size();
  std::optional<SeenPatch> seen;
  for (unsigned i = 0; i < count; ++i) {
    if (call->valid[i] != -1) continue;
    call->valid[i] = 0;
    const std::size_t index = RTCHitN_primID(call->hit, count, i);
    if (index >= cast.patches.size()) continue;
    if (index != seen_index) seen.emplace(cast.patches[index], cast.p_m);
    seen_index = index;
    const std::size_t lane = RTCRayN_id(call->ray, count, i);
    // Embree 3.12 asks about rays beyond the last one too, which its caller has masked out, as it
    // has those out of view: nothing is below their NaN.
    if (lane >= cast.directions.size()) continue;
    const double distance_m = seen->distance_m(cast.directions[lane]);
    if (!(distance_m >= cast.near_m && distance_m <= cast.far_m)) continue;
    if (!(distance_m < cast.distance_m[lane])) continue;
    call->valid[i] = -1;
    cast.distance_m[lane] = distance_m;
    RTCRayN_tfar(call->ray, count, i) = static_cast<float>(distance_m + cast.margin_m);
  }
}

// Around what is solid of a patch, relative to the block and further out by the margin. Of what
// rays meet of whole patches two thirds are open, and a quadrangle has a tight box around it where
// a disc has a cube, so that far fewer boxes overlap on walls and ground.
std::array<Eigen::Vector3d, 4> corners_m(const ExactPatch& patch, const Eigen::Vector3d& origin_m,
                                         double margin) {
  const Eigen::Vector3d centre_m = patch.centre_m - origin_m;
  if (patch.solid == 0) return {centre_m, centre_m, centre_m, centre_m};
  const SolidBounds solid = bounds_of_solid(patch.solid);
  const auto at_m = [&](double along_m, double across_m) -> Eigen::Vector3d {
    return centre_m + along_m * patch.side + across_m * patch.other_side;
  };
  const double low_u_m = solid.low_along * patch.half_side_m - margin;
  const double high_u_m = solid.high_along * patch.half_side_m + margin;
  const double low_v_m = solid.low_across * patch.half_side_m - margin;
  const double high_v_m = solid.high_across * patch.half_side_m + margin;
  return {at_m(low_u_m, low_v_m), at_m(high_u_m, low_v_m), at_m(high_u_m, high_v_m),
          at_m(low_u_m, high_v_m)};
}

RTCGeometry geometry_of(RTCDevice device, std::span<const ExactPatch> patches,
                        const Eigen::Vector3d& origin_m, double margin) {
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_QUAD);
  const std::size_t count = std::max<std::size_t>(1, patches.size());
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), 4 * count));
  auto* corners = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, 4 * sizeof(std::uint32_t), count));
  if (vertices == nullptr || corners == nullptr) {
    rtcReleaseGeometry(geometry);
    throw std::bad_alloc();
  }
  std::fill_n(vertices, 12, 0.0F);  // without any patch: one of no extent
  std::iota(corners, corners + 4 * count, 0U);
  for (const ExactPatch& patch : patches) {
    for (const Eigen::Vector3d& corner_m : corners_m(patch, origin_m, margin)) {
      const Eigen::Vector3f at_m = corner_m.cast<float>();
      vertices = std::copy_n(at_m.data(), 3, vertices);
    }
  }
  rtcSetGeometryIntersectFilterFunction(geometry, &decide_in_double);
  return geometry;
}

}  // namespace

// The patches that the sites of one block may see, for rays of `far_m` and shorter.
struct BlockScene::Patches {
  Patches(RTCDevice device, std::span<const SurfacePatch> seen, const Eigen::Vector3d& origin,
          double far_m)
      : origin_m(origin), margin(margin_m(far_m)), scene(rtcNewScene(device), &rtcReleaseScene) {
    check_memory(device);
    exact.reserve(seen.size());
    for (const SurfacePatch& patch : seen) exact.push_back(exact_patch(patch));
    // Robust: no ray slips between the two triangles that a quadrangle is for Embree.
    rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);
    const RTCGeometry geometry = geometry_of(device, exact, origin_m, margin);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene.get(), geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene.get());
    check_memory(device);
  }

  Eigen::Vector3d origin_m;
  double margin;
  std::vector<ExactPatch> exact;
  Scene scene;
};

namespace {

// Casts one fan of rays on the patches of one block.
class FanCaster {
 public:
  FanCaster(const BlockScene::Patches& patches, const RayFan& fan)
      : patches_(patches), fan_(fan), packets_(packets_of(fan, patches.margin)) {}

  // `number` is the site's in the block.
  void cast(const Site& site, std::size_t number, std::span<double> distance_m) const {
    const Eigen::Vector3f origin_m = (site.p_map_m - patches_.origin_m).cast<float>();
    const Eigen::Vector2d forward = fan_.view.forward(site);
    ExactCast exact;
    start_query(exact);
    exact.patches = patches_.exact;
    exact.p_m = site.p_map_m;
    exact.near_m = fan_.near_m;
    exact.far_m = fan_.far_m;
    exact.margin_m = patches_.margin;
    for (std::size_t first = 0; first < distance_m.size(); first += kPacket) {
      Packet packet = packets_[first / kPacket];
      const std::size_t count = std::min(kPacket, distance_m.size() - first);
      exact.directions = std::span(fan_.directions).subspan(first, count);
      exact.distance_m.fill(kNotHit_m);
      std::fill_n(packet.rays.ray.org_x, kPacket, origin_m.x());
      std::fill_n(packet.rays.ray.org_y, kPacket, origin_m.y());
      std::fill_n(packet.rays.ray.org_z, kPacket, origin_m.z());
      const auto is_left_out = [&](std::size_t lane) {
        return !fan_.view.holds(forward, exact.directions[lane]) ||
               (fan_.wants && !fan_.wants(number, first + lane));
      };
      // Neighbours: a third faster.
      if (takes_all_ || mask(is_left_out, exact, packet)) {
        intersect_8(packet.valid.data(), patches_.scene.get(), exact, EmbreeRays::kNeighbours,
                    packet.rays);
      }
      std::copy_n(exact.distance_m.begin(), count,
                  distance_m.begin() + static_cast<std::ptrdiff_t>(first));
    }
  }

 private:
  // Whether any ray is left.
  static bool mask(const auto& is_left_out, ExactCast& exact, Packet& packet) {
    bool is_any_left = false;
    for (std::size_t lane = 0; lane < exact.directions.size(); ++lane) {
      if (!is_left_out(lane)) {
        is_any_left = true;
        continue;
      }
      packet.valid[lane] = 0;
      exact.distance_m[lane] = std::numeric_limits<double>::quiet_NaN();
    }
    return is_any_left;
  }

  const BlockScene::Patches& patches_;
  const RayFan& fan_;
  std::vector<Packet> packets_;
  const bool takes_all_ = fan_.view.is_all_round() && !fan_.wants;
};

}  // namespace

void replace_caster_isa(CasterIsa isa) { chosen_isa = isa; }

BlockScene::BlockScene(const Sites& sites, const SiteBlock& block,
                       std::unique_ptr<const Patches> patches)
    : sites_(sites), block_(block), patches_(std::move(patches)) {}
BlockScene::BlockScene(BlockScene&&) noexcept = default;
BlockScene::~BlockScene() = default;

void BlockScene::cast(const RayFan& fan, int threads, const TakeDistances& take) const {
  const FanCaster caster(*patches_, fan);
  parallel_for(block_.sites.size(), threads, [&](std::size_t i) {
    std::vector<double> distance_m(fan.directions.size());
    caster.cast(sites_.sites[block_.sites[i]], i, distance_m);
    take(i, distance_m);
  });
}

struct SiteCaster::Scenes {
  Device device = make_device();
};

SiteCaster::SiteCaster(const TiledSurface& surface, const Sites& sites, double reach_m,
                       ChangePatch change)
    : surface_(surface),
      sites_(sites),
      far_m_(reach_m),
      reach_m_(reach_m + std::numbers::sqrt2 * surface.reach_m()),
      change_(std::move(change)),
      blocks_(blocks_of_sites(sites)),
      scenes_(std::make_unique<Scenes>()) {}

SiteCaster::SiteCaster(SiteCaster&&) noexcept = default;
SiteCaster::~SiteCaster() = default;

Result<std::vector<SurfacePatch>> SiteCaster::patches_near(const SiteBlock& block) const {
  const double moved_m = change_ ? kMostMoved_m : 0.0;
  SIGHTLINE_ASSIGN(Surface surface, surface_.over(box_around(block, reach_m_ + moved_m)));
  if (change_) {
    for (SurfacePatch& patch : surface.patches) change_(patch);
  }
  return sightline::patches_near(block, surface, reach_m_);
}

Result<BlockScene> SiteCaster::scene(const SiteBlock& block) const {
  SIGHTLINE_ASSIGN(const std::vector<SurfacePatch> patches, patches_near(block));
  return BlockScene(sites_, block,
                    std::make_unique<const BlockScene::Patches>(scenes_->device.get(), patches,
                                                                block.origin_m, far_m_));
}

Result<void> cast_at_sites(PassContext& ctx, const TiledSurface& surface, const Sites& sites,
                           const RayFan& fan, const TakeDistances& take) {
  if (surface.head().frame != sites.frame) {
    return Error{ErrorCode::kMismatchedInputs, "surface and sites are in different frames"};
  }
  const SiteCaster caster(surface, sites, fan.far_m);
  std::atomic<std::size_t> done = 0;
  for (const SiteBlock& block : caster.blocks()) {
    RayFan of_block = fan;
    if (fan.wants) {
      of_block.wants = [&](std::size_t i, std::size_t ray) {
        return fan.wants(block.sites[i], ray);
      };
    }
    SIGHTLINE_ASSIGN(const BlockScene scene, caster.scene(block));
    scene.cast(of_block, ctx.threads, [&](std::size_t i, std::span<const double> distance_m) {
      take(block.sites[i], distance_m);
      ctx.progress(++done, sites.sites.size());
    });
  }
  return {};
}

AzimuthView::AzimuthView(const SensorProfile& sensor)
    : is_all_round_(sensor.sees_all_round()),
      least_cosine_(portable_sin_cos(sensor.azimuth_view_deg * std::numbers::pi / 360.0).cos),
      x_in_vehicle_(sensor.T_vehicle_lidar.linear().col(0)) {}

Eigen::Vector2d AzimuthView::forward(const Site& site) const {
  constexpr double kLeastLevel = 1e-3;  // a turn of half a degree about it turns it round
  const Eigen::Matrix3d& R_map_vehicle = site.T_map_vehicle.linear();
  Eigen::Vector2d forward = (R_map_vehicle * x_in_vehicle_).head<2>();
  if (forward.norm() < kLeastLevel) forward = R_map_vehicle.col(0).head<2>();
  return forward.normalized();
}

}  // namespace sightline
