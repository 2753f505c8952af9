#include "passes/model/add_history.h"

#include <algorithm>

#include "passes/model/forest/measured_columns.h"

namespace sightline {

Result<FactorTable> add_history(PassContext&, const NoOptions&, const FactorTable& factors,
                                const MeasuredDrives& measured, const PredictedError& predicted) {
  const bool is_told = std::ranges::count(predicted.has_history, std::uint8_t{1}) > 0;
  if (!is_told) return factors;
  FactorTable table = factors;
  for (const MeasuredError& drive : measured.drives) {
    if (drive.scan_of_site.size() != factors.site_count || drive.looks != factors.looks) {
      return Error{ErrorCode::kMismatchedInputs,
                   "drive '" + drive.drive + "' was measured at other sites or ranges", "",
                   "pass add-history"};
    }
    table = with_measured_columns(table, drive);
  }
  return table;
}

}  // namespace sightline
