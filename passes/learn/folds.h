#pragma once

#include <cstdint>
#include <vector>

#include "compiler/base/result.h"
#include "formats/sites.h"

// Neighbouring sites see the same walls, so what judges a forest must lie elsewhere: the route is
// cut into blocks, blocks are dealt to folds, and the trees that speak for a fold have seen nothing
// within a buffer around it.

namespace sightline {

struct FoldOptions {
  double block_m = 60.0;  // at least this much route with labels in each block
  int fold_count = 5;     // at most
};

struct Folds {
  std::vector<std::uint32_t> block_of_site;  // ascending along the route
  std::uint32_t block_count = 0;
  std::uint32_t fold_count = 0;
  double labelled_route_m = 0.0;

  // Blocks are dealt in turn, so that each fold samples the whole route.
  [[nodiscard]] std::uint32_t fold_of_site(std::size_t site) const {
    return block_of_site[site] % fold_count;
  }
};

// Blocks of equal labelled route, as many as fit. Errors: no-training-rows where no site has a
// label, drive-too-short where fewer than two blocks fit, saying how many metres are needed.
Result<Folds> make_folds(const Sites& sites, const std::vector<std::uint8_t>& has_label,
                         const FoldOptions& options);

// Per site: 1 where its sensor origin lies within buffer_m (3D, so that a route that crosses itself
// does not leak) of any site of the fold, or in the fold.
std::vector<std::uint8_t> sites_near_fold(const Sites& sites, const Folds& folds,
                                          std::uint32_t fold, double buffer_m);

}  // namespace sightline
