#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "formats/surroundings/ndt_map.h"

namespace sightline {

// The NDs around one site, nearest first (ties by cell key), cut into shells by the ranges: those
// within ranges_m[r] are the first end[r]. Whether they can be seen does not matter.
struct Vicinity {
  std::vector<double> ranges_m;         // ascending
  std::vector<std::size_t> end;         // per range
  std::vector<std::uint32_t> nd_index;  // into the list that it was made from
  std::vector<double> distance_m;       // of each mean from the site, ascending

  [[nodiscard]] std::size_t shell_begin(std::size_t range) const {
    return range == 0 ? 0 : end[range - 1];
  }
};

// `candidates` are indices into `nds`, in any order, each once; what lies beyond the longest range
// is left out.
Vicinity vicinity_of(const Eigen::Vector3d& p_map_m, std::span<const Nd> nds,
                     std::span<const std::uint32_t> candidates,
                     const std::vector<double>& ranges_m);

}  // namespace sightline
