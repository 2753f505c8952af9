#include "passes/model/forest/folds.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <set>
#include <utility>

#include "formats/base/check.h"
#include "formats/drive/shared_scans.h"
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

bool have_common_number(const std::vector<std::uint32_t>& a, const std::vector<std::uint32_t>& b) {
  return std::ranges::find_first_of(a, b) != a.end();
}

// [place][recording]
std::vector<std::vector<std::uint32_t>> numbers_of(
    const std::vector<const RecordingCards*>& places) {
  std::vector<const RecordingCard*> all;
  for (const RecordingCards* place : places) {
    for (const RecordingCard& card : place->cards) all.push_back(&card);
  }
  const std::vector<std::uint32_t> numbers = recording_numbers(all);
  std::vector<std::vector<std::uint32_t>> of_places;
  auto next = numbers.begin();
  for (const RecordingCards* place : places) {
    const auto end = next + std::ssize(place->cards);
    of_places.emplace_back(next, end);
    next = end;
  }
  return of_places;
}

void join(std::uint32_t a, std::uint32_t b, std::vector<std::uint32_t>& group) {
  std::ranges::replace(group, std::max(a, b), std::min(a, b));
}

// From 0 on, in the order of the places.
std::vector<std::uint32_t> renumbered(std::vector<std::uint32_t> group) {
  std::map<std::uint32_t, std::uint32_t> number;
  for (const std::uint32_t of_place : group) {
    number.try_emplace(of_place, static_cast<std::uint32_t>(number.size()));
  }
  for (std::uint32_t& of_place : group) of_place = number.at(of_place);
  return group;
}

std::vector<std::uint32_t> joined_places(
    const std::vector<std::vector<std::uint32_t>>& recordings) {
  std::vector<std::uint32_t> group(recordings.size());
  for (std::uint32_t i = 0; i < recordings.size(); ++i) {
    group[i] = i;
    for (std::uint32_t j = 0; j < i; ++j) {
      if (have_common_number(recordings[i], recordings[j])) join(group[i], group[j], group);
    }
  }
  return renumbered(std::move(group));
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

Origins origins_by_recording(const std::vector<const RecordingCards*>& places) {
  Origins origins{numbers_of(places), {}};
  origins.places = joined_places(origins.recordings);
  return origins;
}

void join_places(std::size_t a, std::size_t b, Origins& origins) {
  join(origins.places[a], origins.places[b], origins.places);
  origins.places = renumbered(std::move(origins.places));
}

Origins origins_of(const TrainingCard& card) {
  Origins origins;
  std::vector<const RecordingCards*> recordings;
  bool is_listed = true;
  for (const PlaceCard& place : card.places) {
    origins.recordings.push_back(place.recording_numbers);
    origins.places.push_back(place.number);
    recordings.push_back(&place.recordings);
    is_listed = is_listed && !place.recording_numbers.empty();
  }
  return is_listed ? origins : origins_by_recording(recordings);
}

std::vector<std::uint32_t> groups_by_recording(const std::vector<const RecordingCards*>& places) {
  return origins_by_recording(places).places;
}

LearntDrives learnt_drives(const DrivenPlaces& places) {
  LearntDrives drives;
  std::vector<const RecordingCards*> recordings;
  for (const DrivenPlace& place : places.places) recordings.push_back(&place.recordings);
  const std::vector<std::vector<std::uint32_t>> numbers_of_places = numbers_of(recordings);
  std::map<std::uint32_t, std::uint32_t> number_of;
  std::set<std::uint32_t> independent;
  for (std::size_t p = 0; p < places.places.size(); ++p) {
    const DrivenPlace& place = places.places[p];
    const std::vector<std::size_t> cards =
        recordings_of_drives(place.recordings, place.drives.size());
    std::vector<std::uint32_t> numbers;
    for (std::size_t drive = 0; drive < place.drives.size(); ++drive) {
      if (cards.empty()) {  // a drive of which nothing is known is none of the others
        numbers.push_back(drives.count++);
        continue;
      }
      const auto [known, is_new] =
          number_of.try_emplace(numbers_of_places[p][cards[drive]], drives.count);
      if (is_new) ++drives.count;
      numbers.push_back(known->second);
      if (!made_the_map(place.recordings, numbers_of_places[p], cards[drive])) {
        independent.insert(known->second);
      }
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
