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

std::vector<Eigen::AlignedBox3d> boxes_of_blocks(const Sites& sites, const Folds& folds) {
  std::vector<Eigen::AlignedBox3d> boxes(folds.block_count);
  for (std::size_t i = 0; i < sites.sites.size(); ++i) {
    boxes[folds.block_of_site[i]].extend(sites.sites[i].p_map_m);
  }
  return boxes;
}

bool is_near_block(const Sites& sites, const Folds& folds, std::size_t site, std::uint32_t block,
                   double buffer_m) {
  const auto& order = folds.block_of_site;
  const auto [first, last] = std::equal_range(order.begin(), order.end(), block);
  for (auto other = first; other != last; ++other) {
    const auto j = static_cast<std::size_t>(other - order.begin());
    const double distance_m = (sites.sites[j].p_map_m - sites.sites[site].p_map_m).norm();
    if (distance_m <= buffer_m) return true;
  }
  return false;
}

}  // namespace

Result<Folds> make_folds(const Sites& sites, const std::vector<std::uint8_t>& has_label,
                         const FoldOptions& options) {
  const auto labelled_count =
      static_cast<std::size_t>(std::count(has_label.begin(), has_label.end(), std::uint8_t{1}));
  if (labelled_count == 0) {
    return Error{ErrorCode::kNoTrainingRows,
                 "none of " + std::to_string(has_label.size()) +
                     " sites has a measured error: no scan of the localization drive lies near one",
                 "", ""};
  }
  Folds folds;
  folds.labelled_route_m = static_cast<double>(labelled_count) * sites.spacing_m;
  const double fitting_blocks = std::floor(folds.labelled_route_m / options.block_m);
  if (fitting_blocks < 2.0) return too_short(folds.labelled_route_m, options.block_m);
  folds.block_count = static_cast<std::uint32_t>(fitting_blocks);
  folds.fold_count = std::min(folds.block_count, static_cast<std::uint32_t>(options.fold_count));
  std::size_t labelled_before = 0;
  for (const std::uint8_t is_labelled : has_label) {
    const std::size_t place = std::min(labelled_before, labelled_count - 1);
    folds.block_of_site.push_back(
        static_cast<std::uint32_t>(place * folds.block_count / labelled_count));
    labelled_before += is_labelled;
  }
  return folds;
}

std::vector<std::uint8_t> sites_near_fold(const Sites& sites, const Folds& folds,
                                          std::uint32_t fold, double buffer_m) {
  const std::vector<Eigen::AlignedBox3d> boxes = boxes_of_blocks(sites, folds);
  std::vector<std::uint8_t> is_near(sites.sites.size(), 0);
  for (std::size_t i = 0; i < sites.sites.size(); ++i) {
    is_near[i] = folds.fold_of_site(i) == fold ? 1 : 0;
    for (std::uint32_t block = fold; block < folds.block_count && is_near[i] == 0;
         block += folds.fold_count) {
      if (boxes[block].exteriorDistance(sites.sites[i].p_map_m) > buffer_m) continue;
      is_near[i] = is_near_block(sites, folds, i, block, buffer_m) ? 1 : 0;
    }
  }
  return is_near;
}

}  // namespace sightline
