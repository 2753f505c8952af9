#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "formats/base/result.h"

namespace sightline {

struct Colour {
  std::uint8_t red = 0;
  std::uint8_t green = 0;
  std::uint8_t blue = 0;
  friend bool operator==(const Colour&, const Colour&) = default;
};

// Pixels row by row from the upper left.
template <class Pixel>
struct Pixels {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<Pixel> pixels;

  Pixels(std::uint32_t columns, std::uint32_t rows, Pixel background = {})
      : width(columns),
        height(rows),
        pixels(static_cast<std::size_t>(columns) * rows, background) {}
  [[nodiscard]] Pixel& at(std::uint32_t column, std::uint32_t row) {
    return pixels[static_cast<std::size_t>(row) * width + column];
  }
  [[nodiscard]] const Pixel& at(std::uint32_t column, std::uint32_t row) const {
    return pixels[static_cast<std::size_t>(row) * width + column];
  }
};
using Raster = Pixels<Colour>;
using GreyRaster = Pixels<std::uint8_t>;  // greys, or any other number of a byte

// The colour at a share of a scale, 0 to 1, of two or more colours in even steps.
Colour colour_on(std::span<const Colour> scale, double share);

// matplotlib's viridis (public domain), which rises in brightness from 0, dark violet, to 1,
// yellow, and reads the same to colour-blind people.
Colour viridis(double share);

// The colour of the index-th of `count` ranges, near to far, on white paper: from violet to a
// yellow green that is still seen.
Colour range_colour_on_paper(std::size_t index, std::size_t count);

// As CSS and SVG write it: "#1e5ac8".
std::string colour_name(const Colour& colour);

// A PNG file of 8 bits a channel, without times or texts: the same picture gives the same bytes
// (of one version of libpng and zlib). Error: bad-argument for a picture of no size.
Result<std::vector<std::byte>> encode_png(const Raster& raster);
Result<std::vector<std::byte>> encode_png(const GreyRaster& raster);

}  // namespace sightline
