#pragma once

#include <cstdint>
#include <vector>

#include "formats/annotation/measured_error.h"
#include "formats/artifact.h"
#include "formats/drive/recording_cards.h"
#include "formats/record/fields.h"

namespace sightline {

// What several drives found at the sites of one map, each by itself.
struct MeasuredDrives {
  std::vector<ByFamily<MeasuredError>> drives;  // in the order in which they were named
  // [drive]: which of the drives that were named it is, from 0 on, ascending; some are left out.
  std::vector<std::uint32_t> numbers;
  std::uint32_t named_count = 0;
};
SIGHTLINE_FIELDS(MeasuredDrives, drives, numbers, named_count)

template <>
struct ArtifactTraits<MeasuredDrives> {
  static constexpr std::string_view kName = "measured-drives";
  static constexpr std::uint32_t kVersion = 3;
};

// Section and number of a localization drive, from 0 on: "localization", "localization[2]", ...
std::string localization_role(std::size_t number);

// Those of `recordings` that are no localization drive which was left out.
RecordingCards without_left_out(const RecordingCards& recordings, const MeasuredDrives& measured);

// Every drive is valid in itself and of as many sites, looks and the localizer as the first.
Result<void> validate(const MeasuredDrives& measured);
// One row per drive; the errors are those of each drive's own table.
Table dump(const MeasuredDrives& measured);

}  // namespace sightline
