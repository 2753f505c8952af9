#pragma once

#include <vector>

#include "formats/drive/look.h"

namespace sightline {

// The ranges that a map compares unless its configuration names others: those of the paper's
// figures, m, ascending.
inline std::vector<double> default_ranges_m() {
  return {10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0, 50.0};
}

// A look of 100 m: so many returns, evenly spaced beyond even_beyond_m, and so many points.
inline Look far_look(std::uint32_t returns, double even_beyond_m, std::uint32_t points,
                     bool is_by_normals) {
  return {.range_m = 100.0,
          .return_count = returns,
          .even_beyond_m = even_beyond_m,
          .point_count = points,
          .is_by_normals = is_by_normals};
}

// The looks that take a sample, from the cheapest to the dearest: the frontier that
// tests/bench/look_bench found, with sensors of 16 to 128 beams. A sample of 200 to 255 points
// costs more than one of 256, of which every second leads.
inline std::vector<Look> default_looks() {
  return {far_look(400, 20.0, 32, true),   far_look(650, 30.0, 40, true),
          far_look(1000, 30.0, 64, true),  far_look(1944, 40.0, 80, true),
          far_look(2850, 40.0, 100, true), far_look(4000, 50.0, 128, true),
          far_look(6000, 50.0, 256, true), far_look(8000, 50.0, 512, false)};
}

// The frontier of those that no map is needed for, beside which a map's stand when it is judged.
inline std::vector<Look> baseline_looks() {
  return {far_look(650, 30.0, 80, false),   far_look(1300, 40.0, 100, false),
          far_look(2850, 50.0, 100, false), far_look(4000, 50.0, 256, false),
          far_look(6000, 50.0, 384, false), far_look(8000, 50.0, 512, false)};
}

// A second look for a plan whose own is dearer, where a map's drive shows that it is as good
// (calibrate_plan).
inline Look cheaper_second_look() {
  Look look = far_look(6000, 50.0, 256, true);
  look.mode = LookMode::kSettle;
  return look;
}

// The plan of a vehicle that tracks, which holds 10 cm in generated towns (tests/bench/README.md,
// "Driving"). Learnt by `driving_bench --learn --timed-every 20` from towns 1 to 8.
inline LookPlan usual_plan() {
  LookPlan plan;
  plan.first = far_look(1944, 30.0, 80, true);
  plan.first.mode = LookMode::kSettle;
  plan.second = far_look(8000, 30.0, 800, true);
  plan.second.mode = LookMode::kSettle;
  plan.test = {{3.0707, 1.0978, -0.7044, -0.1420, -0.7577, 1.7356, 0.3897, 0.3829}, 26.9450};
  plan.doubt_above = -0.8582;
  return plan;
}

}  // namespace sightline
