#include "passes/rays/cast_scans.h"

#include <algorithm>
#include <cmath>

#include "formats/base/units.h"
#include "formats/geometry.h"
#include "passes/matching/scan_preparation.h"

namespace sightline {
namespace {

// Of neighbouring rays at the longest range: two or three meet a voxel there, and more nearer by.
constexpr double kMostApart_leaves = 0.4;

std::vector<Eigen::Vector3d> subsampled_hits(const std::vector<Eigen::Vector3d>& directions,
                                             std::span<const double> distance_m, double leaf_m) {
  std::vector<Eigen::Vector3d> hits_m;
  for (std::size_t i = 0; i < directions.size(); ++i) {
    if (std::isfinite(distance_m[i])) hits_m.emplace_back(distance_m[i] * directions[i]);
  }
  return voxel_subsample(hits_m, leaf_m);
}

using ScanOfSite = std::vector<std::vector<Eigen::Vector3d>>;

TakeDistances take_into(const RayFan& fan, double leaf_m, ScanOfSite& scan_of_site) {
  return [&fan, leaf_m, &scan_of_site](std::size_t site, std::span<const double> distance_m) {
    scan_of_site[site] = subsampled_hits(fan.directions, distance_m, leaf_m);
  };
}

RayFan fan_of(const CastScansOptions& options, const SensorProfile& sensor) {
  return {beam_directions(sensor, azimuth_stride(options, sensor)), options.near_m,
          options.longest_range_m, AzimuthView(sensor)};
}

Error at_pass(Error error) {
  error.place = "pass cast-scans";
  return error;
}

Result<void> check_options(const CastScansOptions& options) {
  if (options.longest_range_m > options.near_m) return {};
  return at_pass({ErrorCode::kBadValue, "longest_range_m must be above near_m"});
}

VirtualScans join(const ScanOfSite& scan_of_site, const CastScansOptions& options) {
  VirtualScans scans;
  scans.longest_range_m = options.longest_range_m;
  scans.leaf_m = options.leaf_m;
  for (const std::vector<Eigen::Vector3d>& scan : scan_of_site) {
    scans.points_m.insert(scans.points_m.end(), scan.begin(), scan.end());
    scans.end.push_back(scans.points_m.size());
  }
  return scans;
}

}  // namespace

std::vector<Eigen::Vector3d> beam_directions(const SensorProfile& sensor, int stride) {
  const auto azimuth_count = static_cast<int>(std::lround(360.0 / sensor.azimuth_step_deg));
  std::vector<Eigen::Vector3d> directions;
  for (const double elevation_deg : sensor.beam_elevations_deg) {
    const double elevation_rad = elevation_deg * kRadPerDeg;
    for (int i = 0; i < azimuth_count; i += stride) {
      const double azimuth_rad = i * sensor.azimuth_step_deg * kRadPerDeg;
      directions.push_back(direction_of(azimuth_rad, elevation_rad));
    }
  }
  return directions;
}

int azimuth_stride(const CastScansOptions& options, const SensorProfile& sensor) {
  const double apart_m = sensor.azimuth_step_deg * kRadPerDeg * options.longest_range_m;
  return std::max(1, static_cast<int>(kMostApart_leaves * options.leaf_m / apart_m));
}

std::vector<OptionField> option_fields(CastScansOptions& options) {
  return {
      number("near_m", options.near_m, "least distance of a hit, m", 0.0, 100.0),
      shared(number("longest_range_m", options.longest_range_m, "largest distance of a hit, m", 1.0,
                    1000.0)),
      shared(number("leaf_m", options.leaf_m, "voxel size for subsampling a scan, m", 0.05, 10.0))};
}

Result<VirtualScans> cast_scans(PassContext& ctx, const CastScansOptions& options,
                                const TiledSurface& surface, const Sites& sites,
                                const SensorProfile& sensor) {
  SIGHTLINE_TRY(check_options(options));
  const RayFan fan = fan_of(options, sensor);
  ScanOfSite scan_of_site(sites.sites.size());
  const Result<void> cast =
      cast_at_sites(ctx, surface, sites, fan, take_into(fan, options.leaf_m, scan_of_site));
  if (!cast) return at_pass(cast.error());
  return join(scan_of_site, options);
}

Result<VirtualScans> cast_scans_in_block(const CastScansOptions& options, const BlockScene& scene,
                                         const SensorProfile& sensor, int threads) {
  SIGHTLINE_TRY(check_options(options));
  const RayFan fan = fan_of(options, sensor);
  ScanOfSite scan_of_site(scene.block().sites.size());
  scene.cast(fan, threads, take_into(fan, options.leaf_m, scan_of_site));
  return join(scan_of_site, options);
}

}  // namespace sightline
