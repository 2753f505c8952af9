#pragma once

#include <Eigen/Core>
#include <compare>
#include <cstdint>

#include "formats/record/fields.h"

// Cells and tiles of regular grids: their keys, what lies in them, and where they are.

namespace sightline {

// A cell of a grid in space: floor(coordinate / edge) per axis, lower face included.
struct CellKey {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;
  friend auto operator<=>(const CellKey&, const CellKey&) = default;
};
SIGHTLINE_FIELDS(CellKey, x, y, z)

// Tiles cut the plane only: all heights of a place belong together.
struct TileKey {
  std::int32_t x = 0;
  std::int32_t y = 0;
  friend auto operator<=>(const TileKey&, const TileKey&) = default;
};
SIGHTLINE_FIELDS(TileKey, x, y)

// floor() of a number within int32, without the library call that plain x86-64 needs.
inline std::int32_t floor_to_int(double value) {
  const auto truncated = static_cast<std::int32_t>(value);
  return truncated - (value < static_cast<double>(truncated) ? 1 : 0);
}

// floor(value / divisor) without rounding; divisor > 0.
inline std::int32_t floor_divide(std::int32_t value, std::int32_t divisor) {
  return value / divisor - (value % divisor < 0 ? 1 : 0);
}

// Each coordinate must lie within 2^31 cells of the origin.
inline CellKey cell_key(const Eigen::Vector3d& point_m, double cell_m) {
  return {floor_to_int(point_m.x() / cell_m), floor_to_int(point_m.y() / cell_m),
          floor_to_int(point_m.z() / cell_m)};
}

// The tile over which a point lies; each coordinate within 2^31 tiles of the origin.
inline TileKey tile_key(const Eigen::Vector3d& point_m, double tile_m) {
  return {floor_to_int(point_m.x() / tile_m), floor_to_int(point_m.y() / tile_m)};
}

// Along one axis.
inline double cell_centre_m(std::int32_t key, double cell_m) { return (key + 0.5) * cell_m; }

inline Eigen::Vector3d cell_centre_m(const CellKey& key, double cell_m) {
  return {cell_centre_m(key.x, cell_m), cell_centre_m(key.y, cell_m), cell_centre_m(key.z, cell_m)};
}

// The high bits of the sum of products: each of them depends on all bits of the key.
inline std::uint32_t hash_of(const CellKey& key) {
  const std::uint64_t mixed = static_cast<std::uint32_t>(key.x) * 0x9e3779b97f4a7c15ULL ^
                              static_cast<std::uint32_t>(key.y) * 0xbf58476d1ce4e5b9ULL ^
                              static_cast<std::uint32_t>(key.z) * 0x94d049bb133111ebULL;
  return static_cast<std::uint32_t>(mixed >> 32);
}

}  // namespace sightline
