#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/look.h"
#include "tests/bench/mapped_town.h"

namespace sightline {

// How a scan is cut and matched, the same at every place.
struct MeasuredRule {
  enum class Kind : std::uint8_t {
    kReference,  // 50 m, every return, searching, as tests/bench/static_50m keeps it
    kLook,       // matched by the localizer for samples
    kAutoware    // sampled by AutowareSampler, matched by this project's searching localizer
  };
  Kind kind = Kind::kLook;
  Look look = {};
  std::uint32_t voxels_apart = 1;  // of a look without a number of points: one in so many
};

bool needs_normals(const MeasuredRule& rule);  // of a map; any other rule does without
std::string to_text(const MeasuredRule& rule);

// A look as text; one without a number of points may end in ", one voxel in 4". Error:
// bad-argument.
Result<MeasuredRule> parse_look_rule(std::string_view text);

// Both frontiers of what was measured (README), without a map and by the normals of its NDs; two
// from 50 m to compare with.
std::vector<std::string> usual_looks();

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
std::vector<RuleFigures> measure_looks(const MappedTown& town, std::span<const MeasuredRule> rules,
                                       const MeasureOptions& options);

}  // namespace sightline
