#include "compiler/views/picture/raster.h"

#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace sightline {
namespace {

// Eleven even steps of viridis.
constexpr std::array<Colour, 11> kViridis = {{{68, 1, 84},
                                              {72, 36, 117},
                                              {65, 68, 135},
                                              {53, 95, 141},
                                              {42, 120, 142},
                                              {33, 145, 140},
                                              {34, 168, 132},
                                              {68, 191, 112},
                                              {122, 209, 81},
                                              {189, 223, 38},
                                              {253, 231, 37}}};

// The last yellow is hard to see on white.
constexpr double kLastOnPaper = 0.88;

// libpng's simple interface: no callbacks, no jumps out of our frames.
Result<std::vector<std::byte>> encode(const void* pixels, std::uint32_t width, std::uint32_t height,
                                      png_uint_32 format) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = width;
  image.height = height;
  image.format = format;
  constexpr int kAsIs = 0;  // no conversion to 8 bits
  constexpr png_int_32 kPacked = 0;
  std::vector<std::byte> file;
  png_alloc_size_t size = 0;
  // Asked first how large it becomes, then written.
  for (const bool is_asking : {true, false}) {
    file.resize(size);
    if (width == 0 || height == 0 ||
        png_image_write_to_memory(&image, is_asking ? nullptr : file.data(), &size, kAsIs, pixels,
                                  kPacked, nullptr) == 0) {
      return Error{ErrorCode::kBadArgument,
                   concat("no PNG can be made of ", width, " x ", height, " pixels")};
    }
  }
  file.resize(size);
  return file;
}

}  // namespace

Colour colour_on(std::span<const Colour> scale, double share) {
  const double place = std::clamp(share, 0.0, 1.0) * static_cast<double>(scale.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(place), scale.size() - 2);
  const double part = place - static_cast<double>(below);
  const Colour& a = scale[below];
  const Colour& b = scale[below + 1];
  const auto mix = [&](std::uint8_t from, std::uint8_t to) {
    return static_cast<std::uint8_t>(std::lround(from + part * (to - from)));
  };
  return {mix(a.red, b.red), mix(a.green, b.green), mix(a.blue, b.blue)};
}

Colour viridis(double share) { return colour_on(kViridis, share); }

Colour range_colour_on_paper(std::size_t index, std::size_t count) {
  if (count < 2) return viridis(0.0);
  return viridis(kLastOnPaper * static_cast<double>(index) / static_cast<double>(count - 1));
}

std::string colour_name(const Colour& colour) {
  return fmt::format("#{:02x}{:02x}{:02x}", colour.red, colour.green, colour.blue);
}

Result<std::vector<std::byte>> encode_png(const Raster& raster) {
  static_assert(sizeof(Colour) == 3);
  return encode(raster.pixels.data(), raster.width, raster.height, PNG_FORMAT_RGB);
}

Result<std::vector<std::byte>> encode_png(const GreyRaster& raster) {
  return encode(raster.pixels.data(), raster.width, raster.height, PNG_FORMAT_GRAY);
}

}  // namespace sightline
