#include "passes/learn/folds.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>

namespace sightline {
namespace {

Error too_short(double labelled_route_m, double block_m) {
  return {ErrorCode::kDriveTooShort,
          "found " + format_double(labelled_route_m) +
              " m of route with measured errors, expected at least " +
              format_double(2.0 * block_m) + " m: two blocks of " + format_double(block_m) +
              " m, so that each can be predicted by trees that never saw it; a longer drive, or a "
              "model trained elsewhere (compile --model), helps",
          "", ""};
}

// The sites of one block, and the box around them.
struct Block {
  std::vector<std::size_t> sites;
  Eigen::AlignedBox3d box_world_m;
};

std::vector<Block> blocks_of_fold(const std::vector<TrainedSite>& sites, const Folds& folds,
                                  std::uint32_t fold) {
  std::vector<Block> blocks(folds.block_count());
  for (std::size_t i = 0; i < sites.size(); ++i) {
    if (folds.fold_of_block[sites[i].block] != fold) continue;
    blocks[sites[i].block].sites.push_back(i);
    blocks[sites[i].block].box_world_m.extend(sites[i].p_world_m);
  }
  std::erase_if(blocks, [](const Block& block) { return block.sites.empty(); });
  return blocks;
}

bool is_near(const TrainedSite& site, const std::vector<TrainedSite>& sites, const Block& block,
             double buffer_m) {
  if (sites[block.sites.front()].place != site.place ||
      block.box_world_m.exteriorDistance(site.p_world_m) > buffer_m) {
    return false;
  }
  return std::ranges::any_of(block.sites, [&](std::size_t other) {
    return (sites[other].p_world_m - site.p_world_m).norm() <= buffer_m;
  });
}

}  // namespace

Result<RouteBlocks> cut_route(const Sites& sites, const std::vector<std::uint8_t>& has_label,
                              double block_m, int least_blocks) {
  const auto labelled_count =
      static_cast<std::size_t>(std::count(has_label.begin(), has_label.end(), std::uint8_t{1}));
  if (labelled_count == 0) {
    return Error{ErrorCode::kNoTrainingRows,
                 "none of " + std::to_string(has_label.size()) +
                     " sites has a measured error: no scan of the localization drive lies near one",
                 "", ""};
  }
  RouteBlocks blocks;
  blocks.labelled_route_m = static_cast<double>(labelled_count) * sites.spacing_m;
  const double fitting_blocks = std::floor(blocks.labelled_route_m / block_m);
  if (fitting_blocks < 2.0 && least_blocks >= 2) return too_short(blocks.labelled_route_m, block_m);
  blocks.block_count = static_cast<std::uint32_t>(std::max(1.0, fitting_blocks));
  std::size_t labelled_before = 0;
  for (const std::uint8_t is_labelled : has_label) {
    const std::size_t place = std::min(labelled_before, labelled_count - 1);
    blocks.block_of_site.push_back(
        static_cast<std::uint32_t>(place * blocks.block_count / labelled_count));
    labelled_before += is_labelled;
  }
  return blocks;
}

void deal_blocks(std::uint32_t most_folds, Folds& folds) {
  const std::uint32_t group_count =
      1 + *std::max_element(folds.fold_of_block.begin(), folds.fold_of_block.end());
  folds.fold_count = std::min(group_count, most_folds);
  for (std::uint32_t& fold : folds.fold_of_block) fold %= folds.fold_count;
}

std::vector<std::uint8_t> sites_near_fold(const std::vector<TrainedSite>& sites, const Folds& folds,
                                          std::uint32_t fold, double buffer_m) {
  const std::vector<Block> blocks = blocks_of_fold(sites, folds, fold);
  std::vector<std::uint8_t> near(sites.size(), 0);
  for (std::size_t i = 0; i < sites.size(); ++i) {
    const bool is_in_fold = folds.fold_of_block[sites[i].block] == fold;
    near[i] = is_in_fold || std::ranges::any_of(blocks, [&](const Block& block) {
                return is_near(sites[i], sites, block, buffer_m);
              })
                  ? 1
                  : 0;
  }
  return near;
}

}  // namespace sightline
