#include "passes/factors/virtual/flat_050.h"

#include <algorithm>

#include "formats/base/portable_math.h"

namespace sightline {

double flat_050(const ShiftGrid& self_score) {
  constexpr double kNear_m = 0.375;
  constexpr double kFar_m = 0.625;
  constexpr std::size_t kNoShift = kShiftCount / 2;
  if (!(self_score[kNoShift] > 0.0)) return 1.0;
  double largest = 0.0;
  for (int j = -kShiftReach; j <= kShiftReach; ++j) {
    for (int i = -kShiftReach; i <= kShiftReach; ++i) {
      const double shift_m = portable_hypot(kShiftStep_m * i, kShiftStep_m * j);
      if (shift_m < kNear_m || shift_m >= kFar_m) continue;
      const int index = (j + kShiftReach) * static_cast<int>(kShiftsPerAxis) + i + kShiftReach;
      largest = std::max(largest, self_score[static_cast<std::size_t>(index)]);
    }
  }
  return largest / self_score[kNoShift];
}

}  // namespace sightline
