#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "formats/annotation/range_table.h"
#include "formats/model/error_model.h"
#include "passes/model/promise/selection.h"

namespace sightline {

// Which of a model's cases set a threshold: it is applied to sites of the same kind.
enum class CaseKind : std::uint8_t { kMapOnly, kHistory };

// Groups of kinds of place, which may have thresholds of their own. kWeak: surfaces constrain one
// direction or all of them weakly (tunnel, corridor, open road, field, hall).
enum class ThresholdGroup : std::uint8_t { kConstrained, kWeak };
inline constexpr std::size_t kThresholdGroupCount = 2;
ThresholdGroup group_of(PlaceKind kind);

// What a threshold is set on.
struct CalibrationCount {
  std::uint32_t blocks = 0;
  std::uint32_t places = 0;  // of different recordings
  std::uint32_t drives = 0;  // different recordings
  PromiseScope scope = PromiseScope::kThisDrive;
};

// The labelled cases of one kind, by blocks that contain any. A block of route counts once, however
// many drives passed it; also where places of the training share a recording: there a case belongs
// to the block of the nearest site of an earlier such place within 10 m. Places that have axes of
// their own and meet nowhere count their n-th blocks as one. A drive is independent if
// its errors were predicted by trees that were not trained on them, and it did not make the map of
// its place. With two independent drives or more, only their cases are used, and a promise from
// them is about the next drive (PromiseScope::kNextDrive). Otherwise all cases are used, and the
// threshold is valid for these drives only (kThisDrive).
struct CalibrationDrives {
  const ErrorModel& model;
  std::vector<std::size_t> cases;
  std::vector<std::uint32_t> block_of_case;
  std::vector<std::uint32_t> cases_in_block;  // none 0
  CalibrationCount count;
};
CalibrationDrives calibration_drives_of(const ErrorModel& model, CaseKind kind,
                                        std::optional<ThresholdGroup> group = {});  // none: all

// [block]: the cases that a choice answers (no flag kUnmet), and those of them that miss the limit
// at the range chosen for them.
struct CaseCounts {
  std::vector<std::uint32_t> answered;
  std::vector<std::uint32_t> missed;
};
CaseCounts count_cases(const CalibrationDrives& calibration_drives, double limit_m,
                       const Choice& choice);

// The largest share of misses among the answered cases of any place.
double worst_place_miss_share(const CalibrationDrives& calibration_drives, double limit_m,
                              const Choice& choice);

// Of the witnesses at any range, m.
double least_error_m(const CalibrationDrives& calibration_drives);

}  // namespace sightline
