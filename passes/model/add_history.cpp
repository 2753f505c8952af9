#include "passes/model/add_history.h"

#include <algorithm>

#include "formats/drive/shared_scans.h"
#include "passes/model/forest/measured_columns.h"

namespace sightline {
namespace {

// Of the drive that was named as this one, from 0 on.
bool is_independent(std::uint32_t number, const ErrorModel& model,
                    const RecordingCards& recordings) {
  const auto card =
      std::ranges::find(recordings.cards, localization_role(number), &RecordingCard::role);
  if (card == recordings.cards.end()) return false;
  const auto is_known_as = [&](const RecordingCard& other) {
    return &other != &*card && have_common_scans(*card, other);
  };
  return std::ranges::none_of(recordings.cards, is_known_as) &&
         std::ranges::none_of(model.card.places, [&](const PlaceCard& place) {
           return have_common_scans(*card, place.recordings);
         });
}

}  // namespace

Result<ByFamily<FactorTable>> add_history(PassContext&, const NoOptions&,
                                          const ByFamily<FactorTable>& factors,
                                          const MeasuredDrives& measured,
                                          const ByFamily<PredictedError>& predicted,
                                          const ByFamily<ErrorModel>& model,
                                          const RecordingCards& recordings) {
  const bool is_told = std::ranges::count(predicted.ranges.has_history, std::uint8_t{1}) > 0;
  if (!is_told) return factors;
  ByFamily<FactorTable> table = factors;
  for (std::size_t i = 0; i < measured.drives.size(); ++i) {
    const MeasuredError& drive = measured.drives[i].ranges;
    if (drive.scan_of_site.size() != factors.ranges.site_count ||
        drive.looks != factors.ranges.looks) {
      return Error{ErrorCode::kMismatchedInputs,
                   concat("drive '", drive.drive, "' was measured at other sites or ranges"), "",
                   "pass add-history"};
    }
    table = with_measured_columns(table, measured.drives[i],
                                  is_independent(measured.numbers[i], model.ranges, recordings));
  }
  return table;
}

}  // namespace sightline
