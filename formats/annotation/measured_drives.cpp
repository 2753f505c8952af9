#include "formats/annotation/measured_drives.h"

#include <algorithm>

namespace sightline {
namespace {

Error invalid_drive(const ByFamily<MeasuredError>& drive, const std::string& message) {
  return {ErrorCode::kInvalidArtifact, message, "", concat("drive '", drive.ranges.drive, "'")};
}

Result<void> validate_beside(const ByFamily<MeasuredError>& first,
                             const ByFamily<MeasuredError>& drive) {
  SIGHTLINE_TRY(validate(drive));
  const bool is_of_one_map = drive.ranges.scan_of_site.size() == first.ranges.scan_of_site.size() &&
                             has_looks_of(drive, first);
  if (!is_of_one_map) {
    return invalid_drive(drive, "its sites or looks differ from those of the first drive");
  }
  // Drives that an earlier map contains have none.
  const std::size_t starts = drive.ranges.tracking_offsets.size();
  const std::size_t first_starts = first.ranges.tracking_offsets.size();
  if (starts != first_starts && starts != 0 && first_starts != 0) {
    return invalid_drive(drive, "its tracking starts differ from those of the first drive");
  }
  const LocalizerProfile& localizer = drive.ranges.matching.localizer;
  const LocalizerProfile& expected = first.ranges.matching.localizer;
  if (localizer == expected) return {};
  return invalid_drive(drive, concat("it was localized by ", to_text(localizer),
                                     ", the first drive by ", to_text(expected)));
}

}  // namespace

std::string localization_role(std::size_t number) {
  return number == 0 ? "localization" : concat("localization[", number + 1, "]");
}

RecordingCards without_left_out(const RecordingCards& recordings, const MeasuredDrives& measured) {
  RecordingCards kept = recordings;
  for (std::uint32_t number = 0; number < measured.named_count; ++number) {
    if (std::ranges::binary_search(measured.numbers, number)) continue;
    std::erase_if(kept.cards, [&](const RecordingCard& card) {
      return card.role == localization_role(number);
    });
  }
  return kept;
}

Result<void> validate(const MeasuredDrives& measured) {
  if (measured.numbers.size() != measured.drives.size()) {
    return Error{ErrorCode::kInvalidArtifact, "drives and their numbers differ in count"};
  }
  std::uint32_t least = 0;
  for (std::size_t i = 0; i < measured.drives.size(); ++i) {
    if (measured.numbers[i] < least || measured.numbers[i] >= measured.named_count) {
      return invalid_drive(measured.drives[i], "the numbers of the drives do not ascend");
    }
    least = measured.numbers[i] + 1;
    SIGHTLINE_TRY(validate_beside(measured.drives.front(), measured.drives[i]));
  }
  return {};
}

Table dump(const MeasuredDrives& measured) {
  Table table{"measured-drives", {"number", "drive", "sites", "measured_sites"}, {}, {}};
  table.facts.emplace_back("named_count", std::int64_t{measured.named_count});
  for (std::size_t i = 0; i < measured.drives.size(); ++i) {
    const MeasuredError& drive = measured.drives[i].ranges;
    const auto count =
        std::ranges::count_if(drive.scan_of_site, [](std::int64_t scan) { return scan >= 0; });
    table.rows.push_back({std::int64_t{measured.numbers[i]}, drive.drive,
                          static_cast<std::int64_t>(drive.scan_of_site.size()),
                          static_cast<std::int64_t>(count)});
  }
  return table;
}

}  // namespace sightline
