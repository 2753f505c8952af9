#include "compiler/views/picture/colours.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

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

}  // namespace

Colour viridis(double share) {
  const double place = std::clamp(share, 0.0, 1.0) * static_cast<double>(kViridis.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(place), kViridis.size() - 2);
  const double part = place - static_cast<double>(below);
  const Colour& a = kViridis[below];
  const Colour& b = kViridis[below + 1];
  const auto mix = [&](std::uint8_t from, std::uint8_t to) {
    return static_cast<std::uint8_t>(std::lround(from + part * (to - from)));
  };
  return {mix(a.red, b.red), mix(a.green, b.green), mix(a.blue, b.blue)};
}

Colour range_colour_on_paper(std::size_t index, std::size_t count) {
  if (count < 2) return viridis(0.0);
  return viridis(kLastOnPaper * static_cast<double>(index) / static_cast<double>(count - 1));
}

std::string colour_name(const Colour& colour) {
  return fmt::format("#{:02x}{:02x}{:02x}", colour.red, colour.green, colour.blue);
}

}  // namespace sightline
