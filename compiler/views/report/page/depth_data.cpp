#include <algorithm>
#include <cmath>
#include <numbers>

#include "compiler/views/picture/png.h"
#include "compiler/views/report/page/json_numbers.h"
#include "compiler/views/report/page/page_data.h"
#include "formats/release/base64.h"

namespace sightline {
namespace {

// Of all images together, as they stand in the page: a long route shows every fourth site's, or
// every tenth's.
constexpr std::size_t kMostBytes = 3'000'000;
constexpr double kLeastSpacing_m = 2.0;   // what is seen a metre on is nearly the same
constexpr std::size_t kSampleCount = 32;  // images from which their size is estimated
constexpr double kNothing = 255.0;
constexpr double kFarthest = 254.0;

std::string image_of(const DepthImages& images, std::size_t site) {
  GreyRaster raster(images.azimuth_count, images.elevation_count);
  for (std::uint32_t row = 0; row < raster.height; ++row) {
    for (std::uint32_t column = 0; column < raster.width; ++column) {
      const std::uint32_t azimuth =
          (images.azimuth_count / 2 + images.azimuth_count - 1 - column) % images.azimuth_count;
      const std::size_t cell =
          static_cast<std::size_t>(images.elevation_count - 1 - row) * images.azimuth_count +
          azimuth;
      const double share =
          static_cast<double>(images.image_of(site)[cell]) / images.longest_range_m;
      raster.at(column, row) = static_cast<std::uint8_t>(
          share <= 1.0 ? std::lround(kFarthest * share) : std::lround(kNothing));
    }
  }
  const Result<std::vector<std::byte>> file = encode_png(raster);
  SIGHTLINE_CHECK(file.has_value());
  return base64_of(*file);
}

// Every how many sites one image is shown.
std::size_t stride_of(const DepthImages& images, double site_spacing_m) {
  const std::size_t step = std::max<std::size_t>(1, images.site_count / kSampleCount);
  std::size_t bytes = 0;
  std::size_t count = 0;
  for (std::size_t site = 0; site < images.site_count; site += step) {
    bytes += image_of(images, site).size();
    ++count;
  }
  const std::size_t all = count == 0 ? 0 : bytes / count * images.site_count;
  const auto least = static_cast<std::size_t>(std::ceil(kLeastSpacing_m / site_spacing_m));
  return std::max(least, all / kMostBytes + 1);
}

}  // namespace

PageJson depth_json(const DepthImages& images, double site_spacing_m) {
  const std::size_t stride = stride_of(images, site_spacing_m);
  std::vector<std::uint32_t> sites;
  std::vector<std::string> texts;
  for (std::size_t site = 0; site < images.site_count; site += stride) {
    sites.push_back(static_cast<std::uint32_t>(site));
    texts.push_back(image_of(images, site));
  }
  const double to_rad = std::numbers::pi / 180.0;
  return {{"site", json_numbers(sites)},
          {"columns", images.azimuth_count},
          {"rows", images.elevation_count},
          {"first_elevation_rad", images.first_elevation_deg * to_rad},
          {"elevation_step_rad", images.elevation_step_deg * to_rad},
          {"longest_m", images.longest_range_m},
          {"images", texts}};
}

}  // namespace sightline
