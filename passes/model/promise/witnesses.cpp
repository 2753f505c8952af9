#include "passes/model/promise/witnesses.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <set>

#include "passes/model/forest/hold_out.h"

namespace sightline {
namespace {

// A drive that a threshold may be set on.
struct WitnessDrive {
  bool is_independent = false;  // trees and map are of other drives
  std::optional<Digest> recording;
};

// [place][drive]
std::vector<std::vector<WitnessDrive>> drives_of(const TrainingCard& card) {
  std::vector<std::vector<WitnessDrive>> drives;
  for (const PlaceCard& place : card.places) {
    const std::vector<RecordingCard> cards =
        recordings_of_drives(place.recordings, place.drives.size());
    std::vector<WitnessDrive> of_place(place.drives.size());
    for (std::size_t drive = 0; drive < cards.size(); ++drive) {
      of_place[drive].recording = cards[drive].digest;
      of_place[drive].is_independent = card.hold_out != hold_out_name(HoldOut::kBlocks) &&
                                       !made_the_map(place.recordings, cards[drive]);
    }
    drives.push_back(std::move(of_place));
  }
  return drives;
}

std::vector<std::uint32_t> groups_of(const TrainingCard& card) {
  std::vector<const RecordingCards*> recordings;
  for (const PlaceCard& place : card.places) recordings.push_back(&place.recordings);
  return groups_by_recording(recordings);
}

// Of the given cases. A drive whose recording is not known counts as one of its place.
WitnessCount count_of(const ErrorModel& model, const std::vector<std::size_t>& cases,
                      const std::vector<std::vector<WitnessDrive>>& drives) {
  const std::vector<std::uint32_t> group_of_place = groups_of(model.card);
  std::set<std::uint32_t> blocks, groups;
  std::set<Digest> known;
  std::set<std::pair<std::uint32_t, std::uint32_t>> unknown;
  for (const std::size_t i : cases) {
    const TrainedSite& site = model.sites[i];
    blocks.insert(site.block);
    groups.insert(group_of_place[site.place]);
    const std::optional<Digest>& recording = drives[site.place][site.drive].recording;
    if (recording) {
      known.insert(*recording);
    } else {
      unknown.insert({site.place, site.drive});
    }
  }
  return {static_cast<std::uint32_t>(blocks.size()), static_cast<std::uint32_t>(groups.size()),
          static_cast<std::uint32_t>(known.size() + unknown.size()), PromiseScope::kThisDrive};
}

void add_case(std::size_t i, std::vector<std::uint32_t>& dense_block, Witnesses& witnesses) {
  std::uint32_t& block = dense_block[witnesses.model.sites[i].block];
  if (block == std::numeric_limits<std::uint32_t>::max()) {
    block = static_cast<std::uint32_t>(witnesses.cases_in_block.size());
    witnesses.cases_in_block.push_back(0);
  }
  witnesses.cases.push_back(i);
  witnesses.block_of_case.push_back(block);
  ++witnesses.cases_in_block[block];
}

}  // namespace

Witnesses witnesses_of(const ErrorModel& model, CaseKind kind) {
  const std::vector<std::vector<WitnessDrive>> drives = drives_of(model.card);
  std::vector<std::size_t> all, independent;
  for (std::size_t i = 0; i < model.sites.size(); ++i) {
    const TrainedSite& site = model.sites[i];
    if (site.has_label == 0 || (site.has_history == 1) != (kind == CaseKind::kHistory)) continue;
    all.push_back(i);
    if (drives[site.place][site.drive].is_independent) independent.push_back(i);
  }
  Witnesses witnesses{model, {}, {}, {}, count_of(model, independent, drives)};
  const bool is_next_drive = witnesses.count.drives >= 2;
  if (!is_next_drive) witnesses.count = count_of(model, all, drives);
  witnesses.count.scope = is_next_drive ? PromiseScope::kNextDrive : PromiseScope::kThisDrive;
  std::vector<std::uint32_t> dense_block(model.card.block_count,
                                         std::numeric_limits<std::uint32_t>::max());
  for (const std::size_t i : is_next_drive ? independent : all) add_case(i, dense_block, witnesses);
  return witnesses;
}

std::vector<std::uint32_t> missed_cases(const Witnesses& witnesses, double limit_m,
                                        const Choice& choice) {
  std::vector<std::uint32_t> missed(witnesses.cases_in_block.size(), 0);
  for (std::size_t i = 0; i < witnesses.cases.size(); ++i) {
    const std::size_t site = witnesses.cases[i];
    const double error_m = witnesses.model.measured(site, choice.range_index[site]);
    if (error_m > limit_m) ++missed[witnesses.block_of_case[i]];
  }
  return missed;
}

double worst_place_miss_share(const Witnesses& witnesses, double limit_m, const Choice& choice) {
  const ErrorModel& model = witnesses.model;
  std::vector<std::size_t> missed(model.card.places.size(), 0);
  std::vector<std::size_t> count(model.card.places.size(), 0);
  for (const std::size_t i : witnesses.cases) {
    const std::uint32_t place = model.sites[i].place;
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

double least_error_m(const Witnesses& witnesses) {
  double least_m = std::numeric_limits<double>::infinity();
  for (const std::size_t site : witnesses.cases) {
    for (std::size_t range = 0; range < witnesses.model.ranges.size(); ++range) {
      least_m = std::min(least_m, witnesses.model.measured(site, range));
    }
  }
  return least_m;
}

}  // namespace sightline
