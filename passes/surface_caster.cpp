#include "passes/surface_caster.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "compiler/base/check.h"

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

using DiscsByBlock = std::map<TileKey, std::vector<std::uint32_t>>;

std::vector<std::uint32_t> discs_near(const TileKey& block, const DiscsByBlock& discs_by_block,
                                      const Surface& surface, double reach_m) {
  std::vector<std::uint32_t> near;
  const auto rings = static_cast<std::int32_t>(std::ceil(reach_m / kBlock_m));
  for (std::int32_t x = block.x - rings; x <= block.x + rings; ++x) {
    for (std::int32_t y = block.y - rings; y <= block.y + rings; ++y) {
      const auto found = discs_by_block.find({x, y});
      if (found == discs_by_block.end()) continue;
      for (const std::uint32_t disc : found->second) {
        if (distance_to_block_m(surface.discs[disc].centre_m, block) <= reach_m) {
          near.push_back(disc);
        }
      }
    }
  }
  std::sort(near.begin(), near.end(), [&](std::uint32_t a, std::uint32_t b) {
    return surface.discs[a].key < surface.discs[b].key;
  });
  return near;
}

// Distance to the plane of a disc, kept within what the disc allows where the ray grazes it.
double distance_to_disc_m(const SurfaceDisc& disc, const Eigen::Vector3d& p_m,
                          const Eigen::Vector3d& direction) {
  const Eigen::Vector3d to_centre_m = disc.centre_m - p_m;
  const double along_m = to_centre_m.dot(direction);
  const double plane_m = disc.normal.dot(to_centre_m) / disc.normal.dot(direction);
  if (!std::isfinite(plane_m)) return along_m;
  return std::clamp(plane_m, along_m - disc.radius_m, along_m + disc.radius_m);
}

// One device for the process: it holds no results. One instruction set, because Embree's last bits
// differ between them.
RTCDevice device() {
  static const RTCDevice kDevice = rtcNewDevice("max_isa=avx2,set_affinity=0");
  SIGHTLINE_CHECK(kDevice != nullptr);
  return kDevice;
}

struct Packet {
  alignas(32) std::array<int, kPacket> valid;
  RTCRayHit8 rays;
};

void fill_packet(const Eigen::Vector3f& origin_m, std::span<const Eigen::Vector3d> directions,
                 float near_m, float far_m, Packet& packet) {
  for (std::size_t lane = 0; lane < kPacket; ++lane) {
    packet.valid[lane] = lane < directions.size() ? -1 : 0;
    const Eigen::Vector3f direction =
        directions[std::min(lane, directions.size() - 1)].cast<float>();
    packet.rays.ray.org_x[lane] = origin_m.x();
    packet.rays.ray.org_y[lane] = origin_m.y();
    packet.rays.ray.org_z[lane] = origin_m.z();
    packet.rays.ray.dir_x[lane] = direction.x();
    packet.rays.ray.dir_y[lane] = direction.y();
    packet.rays.ray.dir_z[lane] = direction.z();
    packet.rays.ray.tnear[lane] = near_m;
    packet.rays.ray.tfar[lane] = far_m;
    packet.rays.ray.time[lane] = 0.0F;
    packet.rays.ray.mask[lane] = ~0U;
    packet.rays.ray.flags[lane] = 0;
    packet.rays.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
    packet.rays.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
  }
}

}  // namespace

struct SurfaceCaster::Scene {
  RTCScene handle = nullptr;
  ~Scene() { rtcReleaseScene(handle); }
};

std::vector<SiteBlock> blocks_of_sites(const Sites& sites, const Surface& surface, double reach_m) {
  DiscsByBlock discs_by_block;
  double widest_m = 0.0;
  for (std::uint32_t i = 0; i < surface.discs.size(); ++i) {
    discs_by_block[block_key(surface.discs[i].centre_m)].push_back(i);
    widest_m = std::max(widest_m, surface.discs[i].radius_m);
  }
  std::map<TileKey, SiteBlock> blocks;
  for (std::size_t i = 0; i < sites.sites.size(); ++i) {
    blocks[block_key(sites.sites[i].p_map_m)].sites.push_back(i);
  }
  std::vector<SiteBlock> list;
  for (auto& [key, block] : blocks) {
    block.origin_m = {key.x * kBlock_m, key.y * kBlock_m,
                      std::floor(sites.sites[block.sites[0]].p_map_m.z() / kBlock_m) * kBlock_m};
    block.discs = discs_near(key, discs_by_block, surface, reach_m + widest_m);
    list.push_back(std::move(block));
  }
  return list;
}

SurfaceCaster::SurfaceCaster(const Surface& surface, const SiteBlock& block)
    : scene_(std::make_unique<Scene>()), surface_(surface), block_(block) {
  scene_->handle = rtcNewScene(device());
  const RTCGeometry geometry = rtcNewGeometry(device(), RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT);
  auto* vertices = static_cast<float*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4,
                              4 * sizeof(float), std::max<std::size_t>(1, block.discs.size())));
  auto* normals = static_cast<float*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_NORMAL, 0, RTC_FORMAT_FLOAT3,
                              3 * sizeof(float), std::max<std::size_t>(1, block.discs.size())));
  SIGHTLINE_CHECK(vertices != nullptr && normals != nullptr);
  std::fill_n(vertices, 4, 0.0F);  // without any disc: one of no extent
  std::fill_n(normals, 3, 0.0F);
  for (std::size_t i = 0; i < block.discs.size(); ++i) {
    const SurfaceDisc& disc = surface.discs[block.discs[i]];
    const Eigen::Vector3f centre_m = (disc.centre_m - block.origin_m).cast<float>();
    const Eigen::Vector3f normal = disc.normal.cast<float>();
    std::copy_n(centre_m.data(), 3, vertices + 4 * i);
    vertices[4 * i + 3] = static_cast<float>(disc.radius_m);
    std::copy_n(normal.data(), 3, normals + 3 * i);
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene_->handle, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene_->handle);
  SIGHTLINE_CHECK(rtcGetDeviceError(device()) == RTC_ERROR_NONE);
}

SurfaceCaster::~SurfaceCaster() = default;

void SurfaceCaster::cast(const Eigen::Vector3d& p_map_m, const Directions& directions,
                         double near_m, double far_m, std::span<double> distance_m) const {
  SIGHTLINE_CHECK(distance_m.size() == directions.size());
  const Eigen::Vector3f origin_m = (p_map_m - block_.origin_m).cast<float>();
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  Packet packet;
  for (std::size_t first = 0; first < directions.size(); first += kPacket) {
    const std::size_t count = std::min(kPacket, directions.size() - first);
    fill_packet(origin_m, std::span(directions).subspan(first, count), static_cast<float>(near_m),
                static_cast<float>(far_m), packet);
    rtcIntersect8(packet.valid.data(), scene_->handle, &context, &packet.rays);
    for (std::size_t lane = 0; lane < count; ++lane) {
      const bool is_hit = packet.rays.hit.geomID[lane] != RTC_INVALID_GEOMETRY_ID &&
                          packet.rays.hit.primID[lane] < block_.discs.size();
      distance_m[first + lane] =
          is_hit ? distance_to_disc_m(surface_.discs[block_.discs[packet.rays.hit.primID[lane]]],
                                      p_map_m, directions[first + lane])
                 : kInfinity;
    }
  }
}

}  // namespace sightline
