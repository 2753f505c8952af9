#include "formats/text/numbers.h"

#include <cmath>
#include <cstdio>

namespace sightline {

std::string fixed(double value, int decimals) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  return text;
}

std::string in_percent(double share) { return fixed(100.0 * share, 1); }
std::string percent(double share) { return in_percent(share) + " %"; }
std::string whole_percent(double share) { return fixed(std::round(100.0 * share), 0) + " %"; }
std::string in_centimetres(double length_m) { return fixed(100.0 * length_m, 1); }

}  // namespace sightline
