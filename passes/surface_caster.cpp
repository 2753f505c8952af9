#include "passes/surface_caster.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>

#include "compiler/base/check.h"
#include "compiler/base/parallel.h"

namespace sightline {
namespace {

constexpr double kBlock_m = 64.0;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kPacket = 8;  // rays; the width of AVX2

TileKey block_key(const Eigen::Vector3d& point_m) {
  return {floor_to_int(point_m.x() / kBlock_m), floor_to_int(point_m.y() / kBlock_m)};
}

// Distance in the plane from a point to the square of a block; 0 inside.
double distance_to_block_m(const Eigen::Vector3d& point_m, const TileKey& block) {
  const double low_x = block.x * kBlock_m;
  const double low_y = block.y * kBlock_m;
  const double dx = std::max({low_x - point_m.x(), point_m.x() - low_x - kBlock_m, 0.0});
  const double dy = std::max({low_y - point_m.y(), point_m.y() - low_y - kBlock_m, 0.0});
  return std::hypot(dx, dy);
}

// Ascending by key within a block, however the surface was cut into tiles.
using PatchesByBlock = std::map<TileKey, std::vector<std::uint32_t>>;

PatchesByBlock patches_by_block(const Surface& surface) {
  PatchesByBlock by_block;
  for (std::uint32_t i = 0; i < surface.patches.size(); ++i) {
    by_block[block_key(surface.patches[i].centre_m)].push_back(i);
  }
  for (auto& [key, patches] : by_block) {
    std::sort(patches.begin(), patches.end(), [&](std::uint32_t a, std::uint32_t b) {
      return surface.patches[a].key < surface.patches[b].key;
    });
  }
  return by_block;
}

std::vector<std::uint32_t> patches_near(const TileKey& block, const PatchesByBlock& by_block,
                                        const Surface& surface, double reach_m) {
  std::vector<std::uint32_t> near;
  const auto rings = static_cast<std::int32_t>(std::ceil(reach_m / kBlock_m));
  for (std::int32_t x = block.x - rings; x <= block.x + rings; ++x) {
    for (std::int32_t y = block.y - rings; y <= block.y + rings; ++y) {
      const auto found = by_block.find({x, y});
      if (found == by_block.end()) continue;
      for (const std::uint32_t patch : found->second) {
        if (distance_to_block_m(surface.patches[patch].centre_m, block) <= reach_m) {
          near.push_back(patch);
        }
      }
    }
  }
  return near;
}

double half_diagonal_m(const SurfacePatch& patch) {
  return std::numbers::sqrt2 * patch.half_side_m;
}

// Distance to the plane of a patch, kept within what the patch allows where the ray grazes it.
double distance_to_patch_m(const SurfacePatch& patch, const Eigen::Vector3d& p_m,
                           const Eigen::Vector3d& direction) {
  const Eigen::Vector3d to_centre_m = patch.centre_m - p_m;
  const double along_m = to_centre_m.dot(direction);
  const double plane_m = patch.normal.dot(to_centre_m) / patch.normal.dot(direction);
  if (!std::isfinite(plane_m)) return along_m;
  const double reach_m = half_diagonal_m(patch);
  return std::clamp(plane_m, along_m - reach_m, along_m + reach_m);
}

// One device for the process: it holds no results. One instruction set, because Embree's last bits
// differ between them.
RTCDevice device() {
  static const RTCDevice kDevice = rtcNewDevice("max_isa=avx2,set_affinity=0");
  SIGHTLINE_CHECK(kDevice != nullptr);
  return kDevice;
}

// Eight rays from anywhere: what differs from site to site is filled in before each use.
struct Packet {
  alignas(32) std::array<int, kPacket> valid;
  RTCRayHit8 rays;
};

std::vector<Packet> packets_of(const RayFan& fan) {
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
    packet.rays.ray.tnear[lane] = static_cast<float>(fan.near_m);
    packet.rays.ray.tfar[lane] = static_cast<float>(fan.far_m);
    packet.rays.ray.time[lane] = 0.0F;
    packet.rays.ray.mask[lane] = ~0U;
    packet.rays.ray.flags[lane] = 0;
    packet.rays.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
    packet.rays.hit.primID[lane] = RTC_INVALID_GEOMETRY_ID;
    packet.rays.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
  }
  return packets;
}

void set_origin(const Eigen::Vector3f& origin_m, Packet& packet) {
  std::fill_n(packet.rays.ray.org_x, kPacket, origin_m.x());
  std::fill_n(packet.rays.ray.org_y, kPacket, origin_m.y());
  std::fill_n(packet.rays.ray.org_z, kPacket, origin_m.z());
}

// Four corners of each patch, relative to the block. A quadrangle has a tight box around it where a
// disc has a cube, so that far fewer boxes overlap on walls and ground.
RTCGeometry geometry_of(const Surface& surface, const SiteBlock& block) {
  const RTCGeometry geometry = rtcNewGeometry(device(), RTC_GEOMETRY_TYPE_QUAD);
  const std::size_t count = std::max<std::size_t>(1, block.patches.size());
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), 4 * count));
  auto* corners = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, 4 * sizeof(std::uint32_t), count));
  SIGHTLINE_CHECK(vertices != nullptr && corners != nullptr);
  std::fill_n(vertices, 12, 0.0F);  // without any patch: one of no extent
  std::iota(corners, corners + 4 * count, 0U);
  for (std::size_t i = 0; i < block.patches.size(); ++i) {
    const SurfacePatch& patch = surface.patches[block.patches[i]];
    const Eigen::Vector3d u_m = patch.half_side_m * side_of(patch);
    const Eigen::Vector3d v_m = patch.normal.cross(u_m);
    const Eigen::Vector3d centre_m = patch.centre_m - block.origin_m;
    const std::array<Eigen::Vector3d, 4> around_m = {centre_m - u_m - v_m, centre_m + u_m - v_m,
                                                     centre_m + u_m + v_m, centre_m - u_m + v_m};
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const Eigen::Vector3f at_m = around_m[corner].cast<float>();
      std::copy_n(at_m.data(), 3, vertices + 3 * (4 * i + corner));
    }
  }
  return geometry;
}

// Casts a fan of rays on the patches of one block.
class BlockCaster {
 public:
  BlockCaster(const Surface& surface, const SiteBlock& block)
      : surface_(surface), block_(block), scene_(rtcNewScene(device())) {
    const RTCGeometry geometry = geometry_of(surface, block);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
    SIGHTLINE_CHECK(rtcGetDeviceError(device()) == RTC_ERROR_NONE);
  }
  ~BlockCaster() { rtcReleaseScene(scene_); }
  BlockCaster(const BlockCaster&) = delete;
  BlockCaster& operator=(const BlockCaster&) = delete;

  void cast(const Eigen::Vector3d& p_map_m, const RayFan& fan, std::span<const Packet> packets,
            std::span<double> distance_m) const {
    const Eigen::Vector3f origin_m = (p_map_m - block_.origin_m).cast<float>();
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (std::size_t first = 0; first < distance_m.size(); first += kPacket) {
      Packet packet = packets[first / kPacket];
      set_origin(origin_m, packet);
      rtcIntersect8(packet.valid.data(), scene_, &context, &packet.rays);
      const std::size_t count = std::min(kPacket, distance_m.size() - first);
      for (std::size_t lane = 0; lane < count; ++lane) {
        const std::size_t hit = packet.rays.hit.primID[lane];
        distance_m[first + lane] = hit < block_.patches.size()
                                       ? distance_to_patch_m(surface_.patches[block_.patches[hit]],
                                                             p_map_m, fan.directions[first + lane])
                                       : kInfinity;
      }
    }
  }

 private:
  const Surface& surface_;
  const SiteBlock& block_;
  RTCScene scene_;
};

}  // namespace

std::vector<SiteBlock> blocks_of_sites(const Sites& sites, const Surface& surface, double reach_m) {
  const PatchesByBlock by_block = patches_by_block(surface);
  double widest_m = 0.0;
  for (const SurfacePatch& patch : surface.patches) {
    widest_m = std::max(widest_m, half_diagonal_m(patch));
  }
  std::map<TileKey, SiteBlock> blocks;
  for (std::size_t i = 0; i < sites.sites.size(); ++i) {
    blocks[block_key(sites.sites[i].p_map_m)].sites.push_back(i);
  }
  std::vector<SiteBlock> list;
  for (auto& [key, block] : blocks) {
    block.origin_m = {key.x * kBlock_m, key.y * kBlock_m,
                      std::floor(sites.sites[block.sites[0]].p_map_m.z() / kBlock_m) * kBlock_m};
    block.patches = patches_near(key, by_block, surface, reach_m + widest_m);
    list.push_back(std::move(block));
  }
  return list;
}

Result<void> cast_at_sites(PassContext& ctx, const Surface& surface, const Sites& sites,
                           const RayFan& fan, const TakeDistances& take) {
  if (surface.frame != sites.frame) {
    return Error{ErrorCode::kMismatchedInputs, "surface and sites lie in different frames", "", ""};
  }
  const std::vector<Packet> packets = packets_of(fan);
  std::atomic<std::size_t> done = 0;
  // Blocks one after another, so that one scene at a time is in memory; sites side by side.
  for (const SiteBlock& block : blocks_of_sites(sites, surface, fan.far_m)) {
    const BlockCaster caster(surface, block);
    parallel_for(block.sites.size(), ctx.threads, [&](std::size_t i) {
      std::vector<double> distance_m(fan.directions.size());
      caster.cast(sites.sites[block.sites[i]].p_map_m, fan, packets, distance_m);
      take(block.sites[i], distance_m);
      ctx.progress(++done, sites.sites.size());
    });
  }
  return {};
}

}  // namespace sightline
