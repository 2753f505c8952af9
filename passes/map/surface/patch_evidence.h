#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/surroundings/surface_points.h"
#include "passes/map/surface/patch_grid.h"

namespace sightline {

// What was seen of the squares of one patch; counts end at 255.
struct SquareCounts {
  std::array<std::uint8_t, kSquaresOfPatch> returns{};  // lie there
  std::array<std::uint8_t, kSquaresOfPatch> passes{};   // rays that went through and on
};

// Returns in the map frame, and where they were seen from.
struct SeenScan {
  ReturnsInMap returns;
  bool has_origin = false;  // without one rays say nothing
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
};

// Things in the order of their cells. Keeps its memory from one sort() to the next.
class SortedByCell {
 public:
  // numbers[i]: of the cell of thing i, below cell_count or kNone.
  static constexpr std::uint32_t kNone = 0xffffffff;
  void sort(std::span<const std::uint32_t> numbers, std::size_t cell_count) {
    begin_.assign(cell_count + 2, 0);
    // A cell's begin stands one further on until its things have moved it there.
    for (const std::uint32_t number : numbers) {
      if (number != kNone) ++begin_[number + 2];
    }
    for (std::size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
    order_.resize(begin_.back());
    for (std::uint32_t i = 0; i < numbers.size(); ++i) {
      if (numbers[i] != kNone) order_[begin_[numbers[i] + 1]++] = i;
    }
  }

  // Ascending.
  [[nodiscard]] std::span<const std::uint32_t> things_of(std::uint32_t cell) const {
    return std::span(order_).subspan(begin_[cell], begin_[cell + 1] - begin_[cell]);
  }
  // The thing some places further on in the order, if there is one: to be asked for ahead. `thing`
  // is one of things_of().
  [[nodiscard]] std::uint32_t later(const std::uint32_t& thing) const {
    constexpr std::ptrdiff_t kAhead = 12;
    const std::uint32_t* const last = &order_.back();
    return last - &thing > kAhead ? *(&thing + kAhead) : *last;
  }

 private:
  std::vector<std::uint32_t> order_;
  std::vector<std::uint32_t> begin_;  // by cell, in order_; and the end
};

// Counts all returns of a scan without an origin; of others a part of the returns and a smaller
// part of the rays, spread evenly. Of a return that moved only the ray counts.
class PatchEvidence {
 public:
  // Keeps a reference to the grid, which holds `patch_count` patches.
  PatchEvidence(const PatchGrid& grid, std::size_t patch_count);

  // The counts do not depend on the number of threads (0: all there are).
  void add(std::span<const SeenScan> scans, int threads);
  // Once, after the last add() and before counts().
  void finish(int threads);

  // In the order of patches.
  [[nodiscard]] std::span<const SquareCounts> counts() const { return counts_; }

 private:
  // Of many scans together: neighbouring ones see the same patches. 32 bytes each, 8 MiB in all.
  static constexpr std::size_t kReturnsAtOnce = std::size_t{1} << 18;
  // 24 bytes each, and 88 for a ray, of which there are fewer: 14 MiB at most, and one scan.
  static constexpr std::size_t kVisitsAtOnce = std::size_t{1} << 17;

  void add_returns(const SeenScan& scan, int threads);
  void add_rays(const FollowedRays& followed);
  void count_returns(int threads);
  void count_returns(std::uint32_t patch, std::span<const std::uint32_t> returns,
                     const PatchLanes::Places& places);
  void count_passes(int threads);

  const PatchGrid& grid_;
  Eigen::AlignedBox3d box_m_;
  std::vector<SquareCounts> counts_;
  // Not counted yet.
  std::vector<Eigen::Vector3d> returns_m_;  // near patches
  FollowedRays rays_;
  // While things are counted: the numbers of their cells, and they in the order of these.
  std::vector<std::uint32_t> numbers_;
  SortedByCell sorted_;
};

// How many returns of a scan with an origin are counted, and how many of its rays are followed.
struct CountedSights {
  std::uint64_t returns = 0;
  std::uint64_t rays = 0;
};
CountedSights counted_sights(std::uint64_t return_count);

}  // namespace sightline
