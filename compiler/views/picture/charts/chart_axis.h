#pragma once

#include <string>
#include <vector>

namespace sightline {

struct AxisSpan {
  double from = 0.0;
  double to = 1.0;
};

// One axis of a chart: numbers to shares of its length.
struct Axis {
  AxisSpan span;
  std::vector<double> ticks;  // ascending, within the span
  int decimals = 0;           // that tell the ticks apart

  [[nodiscard]] double share(double value) const {
    return (value - span.from) / (span.to - span.from);
  }
  [[nodiscard]] std::string label(double tick) const;
};

// Ticks at multiples of 1, 2 or 5 times a power of ten, about `tick_count` of them. `is_rounded`:
// the axis ends on ticks. A span of no extent is widened.
Axis axis_of(AxisSpan span, int tick_count, bool is_rounded);

}  // namespace sightline
