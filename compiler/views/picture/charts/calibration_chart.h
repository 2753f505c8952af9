#pragma once

#include <string>
#include <vector>

#include "compiler/views/picture/charts/chart.h"
#include "formats/evaluation/evaluation.h"

namespace sightline {

// CSS colours; of limits in turn where there are more of them.
struct CalibrationColours {
  std::string promise = "#7d8792";
  std::vector<std::string> of_limits = {"#0072b2", "#d55e00", "#009e73"};
};

// Promised P(error <= limit) to the right against the share that met the limit upwards, both in per
// cent: a curve a limit, the area of its points as large as there are pairs of site and range
// behind them; the dashed diagonal is a promise kept exactly.
Chart calibration_chart(const Evaluation& evaluation, const CalibrationColours& colours);

}  // namespace sightline
