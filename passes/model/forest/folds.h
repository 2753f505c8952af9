#pragma once

#include <cstdint>
#include <vector>

#include "formats/annotation/sites.h"
#include "formats/base/result.h"
#include "formats/model/error_model.h"

// Neighbouring sites see the same walls, so what judges a forest must lie elsewhere: the route is
// cut into blocks, blocks (or whole places) are dealt to folds, and the trees that speak for a fold
// have seen nothing within a buffer around it.

namespace sightline {

// One place's route, cut.
struct RouteBlocks {
  std::vector<std::uint32_t> block_of_site;  // ascending along the route
  std::uint32_t block_count = 0;
  double labelled_route_m = 0.0;
};

// Blocks of equal labelled route of at least block_m, as many as fit; one where not even one fits
// but least_blocks is 1. Errors: no-training-rows where no site has a label, drive-too-short where
// fewer than least_blocks fit, saying how many metres are needed.
Result<RouteBlocks> cut_route(const Sites& sites, const std::vector<std::uint8_t>& has_label,
                              double block_m, int least_blocks);

struct Folds {
  std::vector<std::uint32_t> fold_of_block;
  std::uint32_t fold_count = 0;
  double labelled_route_m = 0.0;
  std::vector<std::uint32_t> group_of_place;  // equal: of one recording; empty: each is its own

  [[nodiscard]] std::uint32_t block_count() const {
    return static_cast<std::uint32_t>(fold_of_block.size());
  }
};

// Deals blocks, numbered by what stays together, to at most `most_folds` folds in turn, so that
// each fold samples the whole route.
void deal_blocks(std::uint32_t most_folds, Folds& folds);

// Per site: 1 where its sensor origin lies within buffer_m (3D, so that a route that crosses itself
// does not leak) of any site of the fold in a place of the same group, or in the fold.
std::vector<std::uint8_t> sites_near_fold(const std::vector<TrainedSite>& sites, const Folds& folds,
                                          std::uint32_t fold, double buffer_m);

}  // namespace sightline
