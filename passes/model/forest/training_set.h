#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "formats/annotation/driven_places.h"
#include "formats/base/result.h"
#include "formats/model/error_model.h"
#include "passes/model/forest/folds.h"
#include "passes/model/forest/growing/feature_rows.h"
#include "passes/model/forest/growing/grow_trees.h"
#include "passes/model/forest/history.h"

// All that there is to learn, laid out as rows. A place gives two cases for each drive, whose
// errors are the labels: without history, and with what others of its drives found. Of n drives
// one alone is the history of the first, two of the second, and so on up to n - 1, then one again,
// so that the model learns what any number of them is worth. A drive is never both history and
// label.

namespace sightline {

enum class FeatureSet { kPaper, kAll };  // the paper's eleven factors, or all there are

struct TrainingSetOptions {
  FeatureSet features = FeatureSet::kAll;
  double block_m = 60.0;  // route held out together, at least
  int fold_count = 5;     // at most
  HoldOut hold_out = HoldOut::kAuto;
};

struct TrainingSet {
  FeatureRows features;            // [site][range]
  std::vector<TrainedSite> sites;  // of all cases, with a label or without; each with its block
  std::vector<double> labels;      // [site][range]; 0 where there is none
  // [site][range], from tracking starts; empty unless all drives have such errors of a sample.
  std::vector<float> tracking_labels_m;
  std::size_t range_count = 0;
  Folds folds;
  std::vector<PlaceCard> places;
  Origins origins;                           // of them and their recordings
  HoldOut held_out = HoldOut::kBlocks;       // what it came to
  std::vector<std::uint32_t> drive_of_site;  // LearntDrives::number of the drive that labels it
  std::uint32_t drive_count = 0;             // different ones
  bool knows_history = false;                // some place was driven twice
  // Of several where some place was driven three times.
  HistoryKind history_kind = HistoryKind::kOfOneDrive;

  [[nodiscard]] SiteShape shape() const { return {range_count}; }
};

// Errors: those of validate(DrivenPlaces), gather_features, choose_hold_out and cut_route.
Result<TrainingSet> make_training_set(const TrainingSetOptions& options,
                                      const DrivenPlaces& places);

// The labelled rows of the sites where `leave_out` is 0. Where they are more than `most_rows`,
// every second, third, ... site of them alone: neighbours tell nearly the same.
LabelledRows labelled_rows(const TrainingSet& training_set,
                           const std::vector<std::uint8_t>& leave_out, std::size_t most_rows);

}  // namespace sightline
