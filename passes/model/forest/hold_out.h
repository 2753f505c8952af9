#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/annotation/driven_places.h"
#include "formats/base/result.h"
#include "formats/drive/recording_cards.h"

// What must be held out together, so that a threshold is set on drives that the trees did not learn
// from. A recording is known by its digest, however often and under whatever name it is given.

namespace sightline {

// What is held out together. kBlocks: blocks of route; kDrives: blocks of one drive, predicted by
// trees that learnt from other drives, elsewhere; kPlaces: whole places. kAuto: the last of these
// that leaves drives to learn from: places where there are two of different recordings, drives
// where one place was driven twice by other drives than those that made its map, else blocks.
enum class HoldOut { kAuto, kBlocks, kDrives, kPlaces };

// "blocks", "drives", "places", as a model's card says.
std::string hold_out_name(HoldOut hold_out);

// [place]: places that share a recording, directly or by way of others, have one number. Numbers
// ascend from 0 in the order of the places.
std::vector<std::uint32_t> groups_by_recording(const std::vector<const RecordingCards*>& places);

// The drives whose errors are learnt.
struct LearntDrives {
  std::vector<std::vector<std::uint32_t>> number;  // [place][drive]; one recording, one number
  std::uint32_t count = 0;                         // of different recordings
  std::uint32_t independent_count = 0;             // of them that made no map of their place
};
LearntDrives learnt_drives(const DrivenPlaces& places);

// Error: no-training-rows where drives are to be held out and there is one alone.
Result<HoldOut> choose_hold_out(HoldOut wanted, const std::vector<std::uint32_t>& group_of_place,
                                const LearntDrives& drives);

}  // namespace sightline
