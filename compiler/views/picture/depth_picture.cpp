#include "compiler/views/picture/depth_picture.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sightline {
namespace {

constexpr std::uint32_t kPixelsPerCell = 4;
constexpr std::uint32_t kScaleHeight = 16;
constexpr std::uint32_t kScaleGap = 4;
constexpr double kNotch_m = 10.0;
constexpr Colour kNothing = {60, 60, 60};
constexpr Colour kPaper = {255, 255, 255};
constexpr Colour kInk = {0, 0, 0};

// Equal steps of a scale whose brightness falls all the way, so that it also reads in grey.
constexpr std::array<Colour, 6> kScale = {{{255, 240, 170},
                                           {254, 190, 90},
                                           {240, 110, 60},
                                           {190, 45, 100},
                                           {105, 30, 130},
                                           {30, 15, 90}}};

std::uint8_t between(std::uint8_t a, std::uint8_t b, double share) {
  return static_cast<std::uint8_t>(std::lround(a + share * (b - a)));
}

void draw_scale(double longest_m, std::uint32_t first_row, Raster& raster) {
  for (std::uint32_t column = 0; column < raster.width; ++column) {
    const double from_m = longest_m * column / raster.width;
    const double to_m = longest_m * (column + 1) / raster.width;
    const bool is_notch = std::floor(from_m / kNotch_m) != std::floor(to_m / kNotch_m);
    for (std::uint32_t row = first_row; row < first_row + kScaleHeight; ++row) {
      raster.at(column, row) = is_notch ? kInk : colour_of_distance(from_m, longest_m);
    }
  }
}

}  // namespace

Colour colour_of_distance(double distance_m, double longest_m) {
  if (std::isnan(distance_m)) return kPaper;
  if (!std::isfinite(distance_m)) return kNothing;
  const double place =
      std::clamp(distance_m / longest_m, 0.0, 1.0) * static_cast<double>(kScale.size() - 1);
  const auto step = std::min(static_cast<std::size_t>(place), kScale.size() - 2);
  const double share = place - static_cast<double>(step);
  const Colour& a = kScale[step];
  const Colour& b = kScale[step + 1];
  return {between(a.red, b.red, share), between(a.green, b.green, share),
          between(a.blue, b.blue, share)};
}

Raster depth_picture(const DepthImages& images, std::size_t site) {
  const std::uint32_t image_height = kPixelsPerCell * images.elevation_count;
  Raster raster(kPixelsPerCell * images.azimuth_count, image_height + kScaleGap + kScaleHeight,
                kPaper);
  for (std::uint32_t row = 0; row < image_height; ++row) {
    const std::uint32_t elevation = images.elevation_count - 1 - row / kPixelsPerCell;
    for (std::uint32_t column = 0; column < raster.width; ++column) {
      // Azimuths grow to the left, and half a turn lies left of the middle.
      const std::uint32_t from_left = column / kPixelsPerCell;
      const std::uint32_t azimuth =
          (images.azimuth_count / 2 + images.azimuth_count - 1 - from_left) % images.azimuth_count;
      const std::size_t cell = static_cast<std::size_t>(elevation) * images.azimuth_count + azimuth;
      raster.at(column, row) = colour_of_distance(static_cast<double>(images.image_of(site)[cell]),
                                                  images.longest_range_m);
    }
  }
  draw_scale(images.longest_range_m, image_height + kScaleGap, raster);
  return raster;
}

}  // namespace sightline
