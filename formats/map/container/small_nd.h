#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "formats/surroundings/ndt_map.h"

namespace sightline {

// An ND in eleven numbers of a byte each ("Small NDs" in schemas/definitions.md): its count with
// three significant bits, its mean to a 256th of the cell, and its covariance as L D L^T with rows
// and columns in the order of their variances.
struct SmallNd {
  std::uint8_t count = 0;
  std::array<std::uint8_t, 3> mean{};  // from the lower border of the cell, by axis
  std::uint8_t order = 0;              // which of the six orders of the axes
  std::array<std::int8_t, 3> scale{};  // of D: quarters of an octave, in m^2
  std::array<std::int8_t, 3> slope{};  // of L: 127ths; l10, l20, l21
  friend bool operator==(const SmallNd&, const SmallNd&) = default;
};

// Half the step of means in a cell, in units of kMeanUnit_m: a 512th of the cell, rounded down.
std::int32_t half_step_units(double cell_m);

// What the layer "ndt" of a map keeps of an ND, beside its cell.
struct NdRow {
  std::uint32_t point_count = 0;
  std::array<std::int32_t, 3> mean_units{};  // from the cell's centre
  std::array<float, 6> covariance_m2{};      // xx, xy, xz, yy, yz, zz
  friend bool operator==(const NdRow&, const NdRow&) = default;
};

// Rounded as the layer is; and back, without what follows from the covariance.
NdRow row_of(const Nd& nd, double cell_m);
Nd nd_of(const NdRow& row, const CellKey& key, double cell_m);

// The same bits on every machine.
NdRow expanded(const SmallNd& small, std::int32_t half_step_units);
// The nearest.
SmallNd nearest_small(const NdRow& row, std::int32_t half_step_units);
// As a small map keeps it, without what follows from the covariance.
Nd rounded_small(const Nd& nd, double cell_m);
// The one that expands to exactly this row, if there is one.
std::optional<SmallNd> small_of(const NdRow& row, std::int32_t half_step_units);

}  // namespace sightline
