#include "passes/rays/cast_rays.h"

#include <algorithm>
#include <numbers>

#include "formats/base/units.h"
#include "formats/geometry.h"

namespace sightline {
namespace {

DepthImages empty_images(const CastRaysOptions& options, std::size_t site_count) {
  DepthImages images;
  images.azimuth_count = static_cast<std::uint32_t>(options.azimuth_count);
  images.elevation_count = static_cast<std::uint32_t>(options.elevation_count);
  images.first_elevation_deg = options.first_elevation_deg;
  images.elevation_step_deg = options.elevation_step_deg;
  images.near_m = options.near_m;
  images.longest_range_m = options.longest_range_m;
  images.site_count = static_cast<std::uint32_t>(site_count);
  images.distance_m.resize(site_count * images.cells_per_site());
  return images;
}

// Row by row from the lowest elevation, azimuth 0 along +x and counter-clockwise.
std::vector<Eigen::Vector3d> directions_of(const DepthImages& images) {
  std::vector<Eigen::Vector3d> directions;
  directions.reserve(images.cells_per_site());
  for (std::uint32_t row = 0; row < images.elevation_count; ++row) {
    const double elevation_rad =
        (images.first_elevation_deg + row * images.elevation_step_deg) * kRadPerDeg;
    for (std::uint32_t column = 0; column < images.azimuth_count; ++column) {
      const double azimuth_rad = (column + 0.5) * 2.0 * std::numbers::pi / images.azimuth_count;
      directions.push_back(direction_of(azimuth_rad, elevation_rad));
    }
  }
  return directions;
}

RayFan fan_of(const CastRaysOptions& options, const DepthImages& images,
              const SensorProfile& sensor) {
  return {directions_of(images), options.near_m, options.longest_range_m, AzimuthView(sensor)};
}

TakeDistances take_into(DepthImages& images) {
  return [&images](std::size_t site, std::span<const double> distance_m) {
    std::transform(distance_m.begin(), distance_m.end(),
                   images.distance_m.begin() + static_cast<long>(site * distance_m.size()),
                   [](double distance) { return static_cast<float>(distance); });
  };
}

Error at_pass(Error error) {
  error.place = "pass cast-rays";
  return error;
}

Result<void> check_options(const CastRaysOptions& options) {
  if (options.longest_range_m <= options.near_m) {
    return at_pass({ErrorCode::kBadValue, "longest_range_m must be above near_m"});
  }
  const double last_deg =
      options.first_elevation_deg + (options.elevation_count - 1) * options.elevation_step_deg;
  if (last_deg > 90.0) {
    return at_pass({ErrorCode::kBadValue, concat("the last elevation is ", std::to_string(last_deg),
                                                 " degrees, beyond the pole")});
  }
  return {};
}

}  // namespace

std::vector<OptionField> option_fields(CastRaysOptions& options) {
  return {integer("azimuth_count", options.azimuth_count, "columns of a depth image (azimuth)", 8,
                  7200),
          integer("elevation_count", options.elevation_count, "rows of a depth image (elevation)",
                  1, 1800),
          number("first_elevation_deg", options.first_elevation_deg,
                 "elevation of the lowest row, degrees", -90.0, 90.0),
          number("elevation_step_deg", options.elevation_step_deg,
                 "elevation step between rows, degrees", 0.01, 90.0),
          number("near_m", options.near_m, "least distance of a hit, m", 0.0, 100.0),
          shared(number("longest_range_m", options.longest_range_m, "largest distance of a hit, m",
                        1.0, 1000.0))};
}

Result<DepthImages> cast_rays(PassContext& ctx, const CastRaysOptions& options,
                              const TiledSurface& surface, const Sites& sites,
                              const SensorProfile& sensor) {
  SIGHTLINE_TRY(check_options(options));
  DepthImages images = empty_images(options, sites.sites.size());
  const Result<void> cast =
      cast_at_sites(ctx, surface, sites, fan_of(options, images, sensor), take_into(images));
  if (!cast) return at_pass(cast.error());
  return images;
}

Result<DepthImages> cast_rays_in_block(const CastRaysOptions& options, const BlockScene& scene,
                                       const SensorProfile& sensor, int threads) {
  SIGHTLINE_TRY(check_options(options));
  DepthImages images = empty_images(options, scene.block().sites.size());
  scene.cast(fan_of(options, images, sensor), threads, take_into(images));
  return images;
}

}  // namespace sightline
