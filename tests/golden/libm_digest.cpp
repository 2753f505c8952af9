#include "tests/golden/libm_digest.h"

#include <cmath>
#include <vector>

#include "formats/base/hash.h"

namespace sightline::golden {

std::string libm_digest() {
  std::vector<double> values;
  for (int i = 1; i <= 5000; ++i) {
    const double x = 0.01 * i + 1e-7 * i * i;
    values.insert(values.end(), {std::sin(x), std::cos(x), std::exp(-x), std::log(x),
                                 std::atan2(x, 3.0), std::pow(x, 1.7)});
  }
  return to_hex(sha256(std::as_bytes(std::span(values))));
}

}  // namespace sightline::golden
