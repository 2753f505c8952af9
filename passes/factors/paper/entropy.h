#pragma once

#include <span>

#include "formats/base/portable_math.h"

namespace sightline {

// Shannon entropy in bits of a histogram with the given total; 0 log 0 = 0, and 0 where it is
// empty.
inline double entropy_bits(std::span<const double> histogram, double total) {
  double entropy = 0.0;
  for (const double count : histogram) {
    if (count > 0.0) entropy -= count / total * portable_log2(count / total);
  }
  return entropy;
}

}  // namespace sightline
