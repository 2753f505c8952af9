#pragma once

#include <span>
#include <vector>

#include "tests/bench/looks/look_rule.h"
#include "tests/bench/mapped_town.h"

namespace sightline {

// One rule at one place; means over the starts, but work is the sum over them.
struct PlaceFigures {
  double error_m = 0.0, points = 0.0, evaluations = 0.0, work = 0.0;
  bool is_timed = false;
  double time_ms = 0.0, cut_ms = 0.0;  // of one start; cut: the part before the match
};
using RuleFigures = std::vector<PlaceFigures>;  // [place]

struct MeasureOptions {
  double leaf_m = 1.0;           // voxels of a look, but not of the reference
  std::size_t timed_every = 10;  // places
  int threads = 0;
};

// [rule][place]. Error and work from all starts; time is thread CPU time of cut, preparation and
// match from one start at every timed place, all rules in turn there, the caches emptied by writing
// 64 MiB before each.
std::vector<RuleFigures> measure_looks(const MappedTown& town, std::span<const LookRule> rules,
                                       const MeasureOptions& options);

}  // namespace sightline
