#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace sightline {

struct Colour {
  std::uint8_t red = 0;
  std::uint8_t green = 0;
  std::uint8_t blue = 0;
  friend bool operator==(const Colour&, const Colour&) = default;
};

// Pixels row by row from the upper left.
struct Raster {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<Colour> pixels;

  Raster(std::uint32_t columns, std::uint32_t rows, Colour background)
      : width(columns),
        height(rows),
        pixels(static_cast<std::size_t>(columns) * rows, background) {}
  [[nodiscard]] Colour& at(std::uint32_t column, std::uint32_t row) {
    return pixels[static_cast<std::size_t>(row) * width + column];
  }
  [[nodiscard]] const Colour& at(std::uint32_t column, std::uint32_t row) const {
    return pixels[static_cast<std::size_t>(row) * width + column];
  }
};

// Greys, or any other number of a byte, likewise.
struct GreyRaster {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<std::uint8_t> pixels;

  GreyRaster(std::uint32_t columns, std::uint32_t rows)
      : width(columns), height(rows), pixels(static_cast<std::size_t>(columns) * rows, 0) {}
  [[nodiscard]] std::uint8_t& at(std::uint32_t column, std::uint32_t row) {
    return pixels[static_cast<std::size_t>(row) * width + column];
  }
  [[nodiscard]] std::uint8_t at(std::uint32_t column, std::uint32_t row) const {
    return pixels[static_cast<std::size_t>(row) * width + column];
  }
};

}  // namespace sightline
