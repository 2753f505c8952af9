#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "passes/map/surface/patch_grid.h"

namespace sightline {

// What was seen of the squares of one patch; counts end at 255.
struct SquareCounts {
  std::array<std::uint8_t, kSquaresOfPatch> returns{};  // lie there
  std::array<std::uint8_t, kSquaresOfPatch> passes{};   // rays that went through and on
};

// Returns in the map frame, and where they were seen from.
struct SeenScan {
  std::vector<Eigen::Vector3d> points_m;
  bool has_origin = false;  // without one rays say nothing
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
};

// All returns of a scan without an origin; of others a part of the returns and a smaller part of
// the rays, spread evenly, so that dense scans cost what sparse ones do.
class PatchEvidence {
 public:
  // Keeps a reference to the grid, which holds `patch_count` patches.
  PatchEvidence(const PatchGrid& grid, std::size_t patch_count)
      : grid_(grid), counts_(patch_count) {}

  // The counts do not depend on the number of threads.
  void add(std::span<const SeenScan> scans, int threads);

  // In the order of patches.
  [[nodiscard]] std::span<const SquareCounts> counts() const { return counts_; }

 private:
  const PatchGrid& grid_;
  std::vector<SquareCounts> counts_;
};

// How many returns of a scan with an origin are counted, and how many of its rays are followed.
struct CountedSights {
  std::uint64_t returns = 0;
  std::uint64_t rays = 0;
};
CountedSights counted_sights(std::uint64_t return_count);

// How far a ray of a scan is followed at most, m.
inline constexpr double kLongestPass_m = 60.0;

}  // namespace sightline
