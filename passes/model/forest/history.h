#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "formats/annotation/measured_error.h"
#include "formats/annotation/sites.h"
#include "formats/grid/point_grid.h"
#include "passes/model/forest/growing/feature_rows.h"

// What earlier drives found at a place, as features (schemas/definitions.md, "Measured
// history"). Whoever learns from it must take the label from another drive.

namespace sightline {

// What history a model was trained with: where no place of its training had two earlier drives or
// more, how they differ is no feature.
enum class HistoryKind : std::uint8_t { kOfOneDrive, kOfSeveral };

// The sites that a drive measured, found by their places in the map frame.
struct MeasuredPlaces {
  std::vector<std::size_t> sites;  // ascending; by index of a point of the grid
  PointGrid grid;
};
MeasuredPlaces places_measured_by(const MeasuredError& drive, const Sites& sites);

// Names of the features, "history_known" first; logs are natural, of errors in metres. Those of
// several drives are those of one, and more behind them.
const std::vector<std::string>& history_features(HistoryKind kind = HistoryKind::kOfOneDrive);
bool is_history_feature(const std::string& name);

// Of the features that a model knows.
HistoryKind history_kind_of(const std::vector<std::string>& names);

// Features of every site and range, all 0 where no site that a drive measured lies within 6 m.
struct History {
  HistoryKind kind = HistoryKind::kOfOneDrive;
  std::vector<std::uint8_t> is_known;  // [site]
  std::vector<float> values;           // [site][range][feature]
};

// Each drive is of these sites, at any number of ranges that is the same for all.
using EarlierDrives = std::vector<const MeasuredError*>;
History history_of(const Sites& sites, const EarlierDrives& drives, HistoryKind kind);

// The rows with the features of history put in before range_m; null: no history anywhere.
FeatureRows with_history(const FeatureRows& rows, HistoryKind kind, const History* history);

}  // namespace sightline
