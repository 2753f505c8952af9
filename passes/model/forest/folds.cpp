#include "passes/model/forest/folds.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <set>

#include "formats/base/check.h"
#include "formats/grid/point_grid.h"
#include "formats/model/error_model.h"

namespace sightline {
namespace {

Error too_short(double labelled_route_m, double block_m) {
  return {ErrorCode::kDriveTooShort,
          concat("found ", format_double(labelled_route_m),
                 " m of route with measured errors, expected at least ",
                 format_double(2.0 * block_m), " m: two blocks of ", format_double(block_m),
                 " m, for cross-validation. Record a longer drive, or use a model of other places "
                 "(compile --model)")};
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

bool share_a_recording(const RecordingCards& a, const RecordingCards& b) {
  return std::ranges::any_of(a.cards, [&](const RecordingCard& card) {
    return std::ranges::find(b.cards, card.digest, &RecordingCard::digest) != b.cards.end();
  });
}

}  // namespace

Result<RouteBlocks> cut_route(const Sites& sites, const std::vector<std::uint8_t>& has_label,
                              double block_m, int least_blocks) {
  const auto labelled_count =
      static_cast<std::size_t>(std::count(has_label.begin(), has_label.end(), std::uint8_t{1}));
  if (labelled_count == 0) {
    return Error{
        ErrorCode::kNoTrainingRows,
        concat("none of ", has_label.size(),
               " sites has a measured error: no scan of the localization drive is near one")};
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

std::string hold_out_name(HoldOut hold_out) {
  SIGHTLINE_CHECK(hold_out != HoldOut::kAuto);
  if (hold_out == HoldOut::kPlaces) return "places";
  return hold_out == HoldOut::kDrives ? "drives" : "blocks";
}

std::vector<std::uint32_t> groups_by_recording(const std::vector<const RecordingCards*>& places) {
  std::vector<std::uint32_t> group(places.size());
  for (std::uint32_t i = 0; i < places.size(); ++i) {
    group[i] = i;
    for (std::uint32_t j = 0; j < i; ++j) {
      if (!share_a_recording(*places[i], *places[j])) continue;
      const std::uint32_t joined = std::min(group[i], group[j]);
      const std::uint32_t other = std::max(group[i], group[j]);
      std::replace(group.begin(), group.begin() + i + 1, other, joined);
    }
  }
  std::map<std::uint32_t, std::uint32_t> number;
  for (const std::uint32_t of_place : group) {
    number.try_emplace(of_place, static_cast<std::uint32_t>(number.size()));
  }
  for (std::uint32_t& of_place : group) of_place = number.at(of_place);
  return group;
}

LearntDrives learnt_drives(const DrivenPlaces& places) {
  LearntDrives drives;
  std::map<Digest, std::uint32_t> number_of;
  std::set<std::uint32_t> independent;
  for (const DrivenPlace& place : places.places) {
    const std::vector<RecordingCard> cards =
        recordings_of_drives(place.recordings, place.drives.size());
    std::vector<std::uint32_t> numbers;
    for (std::size_t drive = 0; drive < place.drives.size(); ++drive) {
      if (cards.empty()) {  // a drive of which nothing is known is none of the others
        numbers.push_back(drives.count++);
        continue;
      }
      const auto [known, is_new] = number_of.try_emplace(cards[drive].digest, drives.count);
      if (is_new) ++drives.count;
      numbers.push_back(known->second);
      if (!made_the_map(place.recordings, cards[drive])) independent.insert(known->second);
    }
    drives.number.push_back(std::move(numbers));
  }
  drives.independent_count = static_cast<std::uint32_t>(independent.size());
  return drives;
}

Result<HoldOut> choose_hold_out(HoldOut wanted, const std::vector<std::uint32_t>& group_of_place,
                                const LearntDrives& drives) {
  if (wanted == HoldOut::kDrives && drives.count < 2) {
    return Error{ErrorCode::kNoTrainingRows,
                 "one drive was measured, but holding out drives needs two or more: add a drive, "
                 "or set train-model.hold_out=blocks"};
  }
  if (wanted != HoldOut::kAuto) return wanted;
  if (*std::ranges::max_element(group_of_place) > 0) return HoldOut::kPlaces;
  return drives.independent_count >= 2 ? HoldOut::kDrives : HoldOut::kBlocks;
}

}  // namespace sightline
