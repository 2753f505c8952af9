#include "passes/model/forest/hold_out.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "formats/base/check.h"
#include "formats/model/error_model.h"

namespace sightline {
namespace {

bool share_a_recording(const RecordingCards& a, const RecordingCards& b) {
  return std::ranges::any_of(a.cards, [&](const RecordingCard& card) {
    return std::ranges::find(b.cards, card.digest, &RecordingCard::digest) != b.cards.end();
  });
}

}  // namespace

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
                 "one drive alone was measured, and it is to be held out: expected two or more, or "
                 "train-model.hold_out=blocks"};
  }
  if (wanted != HoldOut::kAuto) return wanted;
  if (*std::ranges::max_element(group_of_place) > 0) return HoldOut::kPlaces;
  return drives.independent_count >= 2 ? HoldOut::kDrives : HoldOut::kBlocks;
}

}  // namespace sightline
