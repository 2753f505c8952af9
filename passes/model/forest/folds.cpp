#include "passes/model/forest/folds.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>

#include "formats/grid/point_grid.h"

namespace sightline {
namespace {

Error too_short(double labelled_route_m, double block_m) {
  return {ErrorCode::kDriveTooShort,
          "found " + format_double(labelled_route_m) +
              " m of route with measured errors, expected at least " +
              format_double(2.0 * block_m) + " m: two blocks of " + format_double(block_m) +
              " m, so that each can be predicted by trees that never saw it; a longer drive, or a "
              "model trained elsewhere (compile --model), helps"};
}

std::uint32_t group_of(const Folds& folds, std::uint32_t place) {
  return folds.group_of_place.empty() ? place : folds.group_of_place[place];
}

// The sites of a fold, by their places' group.
std::map<std::uint32_t, PointGrid> grids_of_fold(const std::vector<TrainedSite>& sites,
                                                 const Folds& folds, std::uint32_t fold) {
  std::map<std::uint32_t, std::vector<Eigen::Vector3d>> points_m;
  for (const TrainedSite& site : sites) {
    if (folds.fold_of_block[site.block] != fold) continue;
    points_m[group_of(folds, site.place)].push_back(site.p_world_m);
  }
  std::map<std::uint32_t, PointGrid> grids;
  for (const auto& [group, of_group_m] : points_m) grids.emplace(group, PointGrid(of_group_m));
  return grids;
}

}  // namespace

Result<RouteBlocks> cut_route(const Sites& sites, const std::vector<std::uint8_t>& has_label,
                              double block_m, int least_blocks) {
  const auto labelled_count =
      static_cast<std::size_t>(std::count(has_label.begin(), has_label.end(), std::uint8_t{1}));
  if (labelled_count == 0) {
    return Error{
        ErrorCode::kNoTrainingRows,
        "none of " + std::to_string(has_label.size()) +
            " sites has a measured error: no scan of the localization drive lies near one"};
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
  const std::map<std::uint32_t, PointGrid> grids = grids_of_fold(sites, folds, fold);
  std::vector<std::uint8_t> near(sites.size(), 0);
  for (std::size_t i = 0; i < sites.size(); ++i) {
    const bool is_in_fold = folds.fold_of_block[sites[i].block] == fold;
    const auto of_group = grids.find(group_of(folds, sites[i].place));
    const bool is_near =
        of_group != grids.end() && of_group->second.nearest(sites[i].p_world_m, buffer_m);
    near[i] = is_in_fold || is_near ? 1 : 0;
  }
  return near;
}

}  // namespace sightline
