#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "formats/surroundings/surface.h"

namespace sightline {

// Ascending by order_of() in a surface of such cells and tiles, each asked about once.
inline void sort_patches(const Surface& surface, std::vector<SurfacePatch>& patches) {
  std::vector<std::pair<SurfaceOrder, std::size_t>> order;
  order.reserve(patches.size());
  for (const SurfacePatch& patch : patches)
    order.emplace_back(order_of(patch, surface), order.size());
  std::ranges::sort(order);
  std::vector<SurfacePatch> sorted;
  sorted.reserve(patches.size());
  for (const auto& [place, i] : order) sorted.push_back(patches[i]);
  patches = std::move(sorted);
}

}  // namespace sightline
