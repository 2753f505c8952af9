#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/annotation/driven_places.h"
#include "formats/annotation/sites.h"
#include "formats/base/result.h"
#include "formats/drive/recording_cards.h"
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

// What must be held out together, so that a threshold is set on drives that the trees did not learn
// from. A recording is known by its digest, however often and under whatever name it is given.

// What is held out together. kBlocks: blocks of route; kDrives: blocks of one drive, predicted by
// trees that learnt from other drives, elsewhere; kPlaces: whole places. kAuto: the last of these
// that leaves drives to learn from: places where there are two of different recordings, drives
// where one place was driven twice by other drives than those that made its map, else blocks.
enum class HoldOut { kAuto, kBlocks, kDrives, kPlaces };

// "blocks", "drives", "places", as a model's card says.
std::string hold_out_name(HoldOut hold_out);

// Which recordings of some places are the same, and which places. Numbers ascend from 0 in the
// order of the places.
struct Origins {
  std::vector<std::vector<std::uint32_t>> recordings;  // [place][recording]; the same: one number
  std::vector<std::uint32_t> places;  // [place]: one number for places that share a recording,
                                      // directly or by way of others
};
Origins origins_by_recording(const std::vector<const RecordingCards*>& places);
// Makes two places one.
void join_places(std::size_t a, std::size_t b, Origins& origins);
// Those that a model's card lists; where it lists none, by its recordings.
Origins origins_of(const TrainingCard& card);
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
