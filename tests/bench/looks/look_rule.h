#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/look.h"

namespace sightline {

// How a scan is cut and matched, the same at every place.
struct LookRule {
  enum class Kind : std::uint8_t {
    kReference,  // 50 m, every return, searching, as tests/bench/static_50m keeps it
    kLook,       // matched by the localizer for samples
    kAutoware    // sampled by AutowareSampler, matched by this project's searching localizer
  };
  Kind kind = Kind::kLook;
  Look look = {};
  std::uint32_t voxels_apart = 1;  // of a look without a number of points: one in so many
};

bool needs_normals(const LookRule& rule);  // of a map; any other rule does without
std::string to_text(const LookRule& rule);

// A look as text; one without a number of points may end in ", one voxel in 4". Error:
// bad-argument.
Result<LookRule> parse_look_rule(std::string_view text);

// Both frontiers of what was measured (README), without a map and by the normals of its NDs; two
// from 50 m to compare with.
std::vector<std::string> usual_looks();

}  // namespace sightline
