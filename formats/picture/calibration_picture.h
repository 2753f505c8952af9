#pragma once

#include <string>

#include "formats/evaluation.h"

namespace sightline {

// Promised P(error <= limit) to the right against the share that met the limit upwards, both 0 to 1:
// a curve a limit, its points as large as there are pairs of site and range behind them; the
// diagonal is a promise kept exactly.
std::string calibration_picture_svg(const Evaluation& evaluation);

}  // namespace sightline
