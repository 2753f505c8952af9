#include "passes/model/promise/calibration_drives.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <set>

#include "formats/grid/point_grid.h"
#include "passes/model/forest/folds.h"

namespace sightline {
namespace {

// A drive that a threshold may be set on.
struct WitnessDrive {
  bool is_independent = false;  // trees and map are of other drives
  std::optional<std::uint32_t> recording;
};

// [place][drive]
std::vector<std::vector<WitnessDrive>> drives_of(const TrainingCard& card, const Origins& origins) {
  std::vector<std::vector<WitnessDrive>> drives;
  for (std::size_t p = 0; p < card.places.size(); ++p) {
    const PlaceCard& place = card.places[p];
    const std::vector<std::uint32_t>& numbers = origins.recordings[p];
    const std::vector<std::size_t> cards =
        recordings_of_drives(place.recordings, place.drives.size());
    std::vector<WitnessDrive> of_place(place.drives.size());
    for (std::size_t drive = 0; drive < cards.size(); ++drive) {
      of_place[drive].recording = numbers[cards[drive]];
      of_place[drive].is_independent = card.hold_out != hold_out_name(HoldOut::kBlocks) &&
                                       !made_the_map(place.recordings, numbers, cards[drive]);
    }
    drives.push_back(std::move(of_place));
  }
  return drives;
}

constexpr double kFarthestOwn_m = 1e5;  // axes that begin at 0 reach no farther

// Blocks of earlier places of a group, in the order of their sites.
struct EarlierBlocks {
  std::vector<Eigen::Vector3d> p_world_m;
  std::vector<std::uint32_t> block_of_site;
  std::vector<std::uint32_t> blocks;  // each once

  void add(const Eigen::Vector3d& site_m, std::uint32_t block) {
    p_world_m.push_back(site_m);
    block_of_site.push_back(block);
    if (std::ranges::find(blocks, block) == blocks.end()) blocks.push_back(block);
  }
};

// In axes of their own, two places of one street may be anywhere: the n-th block of the one counts
// as the n-th of the other, so that only what is longer counts again.
std::uint32_t block_by_order(std::uint32_t block, const EarlierBlocks& earlier,
                             std::vector<std::uint32_t>& order) {
  const auto place = std::ranges::find(order, block);
  const auto n = static_cast<std::size_t>(place - order.begin());
  if (place == order.end()) order.push_back(block);
  return n < earlier.blocks.size() ? earlier.blocks[n] : block;
}

// The blocks of a place among those of earlier places of its group.
void join_blocks(const ErrorModel& model, std::uint32_t place, const EarlierBlocks& earlier,
                 std::vector<std::uint32_t>& block_of_site) {
  constexpr double kSameRoute_m = 10.0;  // lanes of one road
  const PointGrid grid(earlier.p_world_m);
  std::vector<std::uint32_t> order;
  for (std::size_t i = 0; i < model.sites.size(); ++i) {
    const TrainedSite& site = model.sites[i];
    if (site.place != place) continue;
    const auto near = grid.nearest(site.p_world_m, kSameRoute_m);
    const bool is_own = site.p_world_m.head<2>().cwiseAbs().maxCoeff() < kFarthestOwn_m;
    if (near) {
      block_of_site[i] = earlier.block_of_site[near->index];
    } else if (is_own) {
      block_of_site[i] = block_by_order(site.block, earlier, order);
    }
  }
}

// [site]: its block of route.
std::vector<std::uint32_t> blocks_of_route(const ErrorModel& model,
                                           const std::vector<std::uint32_t>& group_of_place) {
  std::vector<std::uint32_t> block_of_site;
  for (const TrainedSite& site : model.sites) block_of_site.push_back(site.block);
  for (std::uint32_t place = 1; place < group_of_place.size(); ++place) {
    EarlierBlocks earlier;
    for (std::size_t i = 0; i < model.sites.size(); ++i) {
      const TrainedSite& site = model.sites[i];
      const bool is_of_group = group_of_place[site.place] == group_of_place[place];
      if (site.place < place && is_of_group) earlier.add(site.p_world_m, block_of_site[i]);
    }
    if (!earlier.blocks.empty()) join_blocks(model, place, earlier, block_of_site);
  }
  return block_of_site;
}

// Of the given cases. A drive whose recording is not known counts as one of its place.
CalibrationCount count_of(const ErrorModel& model, const std::vector<std::size_t>& cases,
                          const std::vector<std::uint32_t>& block_of_site,
                          const std::vector<std::vector<WitnessDrive>>& drives,
                          const std::vector<std::uint32_t>& group_of_place) {
  std::set<std::uint32_t> blocks, groups, known;
  std::set<std::pair<std::uint32_t, std::uint32_t>> unknown;
  for (const std::size_t i : cases) {
    const TrainedSite& site = model.sites[i];
    blocks.insert(block_of_site[i]);
    groups.insert(group_of_place[site.place]);
    const std::optional<std::uint32_t>& recording = drives[site.place][site.drive].recording;
    if (recording) {
      known.insert(*recording);
    } else {
      unknown.insert({site.place, site.drive});
    }
  }
  return {static_cast<std::uint32_t>(blocks.size()), static_cast<std::uint32_t>(groups.size()),
          static_cast<std::uint32_t>(known.size() + unknown.size()), PromiseScope::kThisDrive};
}

void add_case(std::size_t i, std::uint32_t& block, CalibrationDrives& calibration_drives) {
  if (block == std::numeric_limits<std::uint32_t>::max()) {
    block = static_cast<std::uint32_t>(calibration_drives.cases_in_block.size());
    calibration_drives.cases_in_block.push_back(0);
  }
  calibration_drives.cases.push_back(i);
  calibration_drives.block_of_case.push_back(block);
  ++calibration_drives.cases_in_block[block];
}

}  // namespace

ThresholdGroup group_of(PlaceKind kind) {
  switch (kind) {
    case PlaceKind::kTunnel:
    case PlaceKind::kCorridor:
    case PlaceKind::kOpenRoad:
    case PlaceKind::kField:
    case PlaceKind::kHall:
      return ThresholdGroup::kWeak;
    default:
      return ThresholdGroup::kConstrained;
  }
}

CalibrationDrives calibration_drives_of(const ErrorModel& model, CaseKind kind,
                                        std::optional<ThresholdGroup> group) {
  const Origins origins = origins_of(model.card);
  const std::vector<std::vector<WitnessDrive>> drives = drives_of(model.card, origins);
  const std::vector<std::uint32_t> block_of_site = blocks_of_route(model, origins.places);
  std::vector<std::size_t> all, independent;
  for (std::size_t i = 0; i < model.sites.size(); ++i) {
    const TrainedSite& site = model.sites[i];
    if (site.has_label == 0 || (site.has_history == 1) != (kind == CaseKind::kHistory)) continue;
    if (group && group_of(site.kind) != *group) continue;
    all.push_back(i);
    if (drives[site.place][site.drive].is_independent) independent.push_back(i);
  }
  CalibrationDrives calibration_drives{
      model, {}, {}, {}, count_of(model, independent, block_of_site, drives, origins.places)};
  const bool is_next_drive = calibration_drives.count.drives >= 2;
  if (!is_next_drive) {
    calibration_drives.count = count_of(model, all, block_of_site, drives, origins.places);
  }
  calibration_drives.count.scope =
      is_next_drive ? PromiseScope::kNextDrive : PromiseScope::kThisDrive;
  std::vector<std::uint32_t> dense_block(model.card.block_count,
                                         std::numeric_limits<std::uint32_t>::max());
  for (const std::size_t i : is_next_drive ? independent : all)
    add_case(i, dense_block[block_of_site[i]], calibration_drives);
  return calibration_drives;
}

CaseCounts count_cases(const CalibrationDrives& calibration_drives, double limit_m,
                       const Choice& choice) {
  const std::vector<std::uint32_t> none(calibration_drives.cases_in_block.size(), 0);
  CaseCounts counts{none, none};
  for (std::size_t i = 0; i < calibration_drives.cases.size(); ++i) {
    const std::size_t site = calibration_drives.cases[i];
    if (!choice.is_answered(site)) continue;
    const std::uint32_t block = calibration_drives.block_of_case[i];
    const double error_m = calibration_drives.model.measured(site, choice.range_index[site]);
    ++counts.answered[block];
    if (error_m > limit_m) ++counts.missed[block];
  }
  return counts;
}

double worst_place_miss_share(const CalibrationDrives& calibration_drives, double limit_m,
                              const Choice& choice) {
  const ErrorModel& model = calibration_drives.model;
  std::vector<std::size_t> missed(model.card.places.size(), 0);
  std::vector<std::size_t> count(model.card.places.size(), 0);
  for (const std::size_t i : calibration_drives.cases) {
    const std::uint32_t place = model.sites[i].place;
    if (!choice.is_answered(i)) continue;
    ++count[place];
    if (model.measured(i, choice.range_index[i]) > limit_m) ++missed[place];
  }
  double worst = 0.0;
  for (std::size_t place = 0; place < count.size(); ++place) {
    if (count[place] == 0) continue;
    worst = std::max(worst, static_cast<double>(missed[place]) / static_cast<double>(count[place]));
  }
  return worst;
}

double least_error_m(const CalibrationDrives& calibration_drives) {
  double least_m = std::numeric_limits<double>::infinity();
  for (const std::size_t site : calibration_drives.cases) {
    for (std::size_t range = 0; range < calibration_drives.model.ranges.size(); ++range) {
      least_m = std::min(least_m, calibration_drives.model.measured(site, range));
    }
  }
  return least_m;
}

}  // namespace sightline
