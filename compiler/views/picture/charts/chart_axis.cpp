#include "compiler/views/picture/charts/chart_axis.h"

#include <algorithm>
#include <cmath>

#include "formats/text/numbers.h"

namespace sightline {
namespace {

constexpr double kSlack = 1e-9;  // of a step: a tick that rounding put beyond the end

double round_step(double least_step) {
  const double power = std::pow(10.0, std::floor(std::log10(least_step)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= least_step * (1.0 - kSlack)) return factor * power;
  }
  return 10.0 * power;
}

}  // namespace

std::string Axis::label(double tick) const {
  const std::string text = fixed(tick, decimals);
  const bool is_zero = text.find_first_not_of("-0.") == std::string::npos;
  return is_zero ? "0" : text;
}

Axis axis_of(AxisSpan span, int tick_count, bool is_rounded) {
  if (!(span.to > span.from)) {
    const double half = span.from == 0.0 ? 0.5 : 0.05 * std::abs(span.from);
    span = {span.from - half, span.to + half};
  }
  const double step = round_step((span.to - span.from) / tick_count);
  if (is_rounded) {
    span = {step * std::floor(span.from / step + kSlack),
            step * std::ceil(span.to / step - kSlack)};
  }
  Axis axis;
  axis.span = span;
  axis.decimals = std::max(0, static_cast<int>(std::ceil(-std::log10(step) - kSlack)));
  const double first = std::ceil(span.from / step - kSlack);
  const double last = std::floor(span.to / step + kSlack);
  for (double i = first; i <= last; i += 1.0) axis.ticks.push_back(step * i);
  return axis;
}

}  // namespace sightline
