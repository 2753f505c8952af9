#include "passes/factors/paper/score_entropy.h"

#include <algorithm>

#include "formats/base/portable_math.h"
#include "passes/factors/paper/entropy.h"

namespace sightline {

double score_entropy(const ShiftGrid& self_score) {
  constexpr double kTemperature = 0.1;  // of the largest score
  const double largest = *std::max_element(self_score.begin(), self_score.end());
  if (!(largest > 0.0)) return portable_log2(static_cast<double>(kShiftCount));
  ShiftGrid weight;
  double total = 0.0;
  for (std::size_t shift = 0; shift < kShiftCount; ++shift) {
    // Less the largest exponent, which the division by the total takes out again.
    weight[shift] = portable_exp((self_score[shift] / largest - 1.0) / kTemperature);
    total += weight[shift];
  }
  return entropy_bits(weight, total);
}

}  // namespace sightline
