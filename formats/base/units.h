#pragma once

#include <cstdint>
#include <numbers>

namespace sightline {

inline constexpr double kRadPerDeg = std::numbers::pi / 180.0;
inline constexpr double kDegPerRad = 180.0 / std::numbers::pi;
inline constexpr std::int64_t kSecond_ns = 1'000'000'000;

}  // namespace sightline
