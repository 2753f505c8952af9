#pragma once

#include <optional>
#include <vector>

#include "passes/weakness/advise_targets.h"
#include "passes/weakness/weak_cause.h"
#include "passes/weakness/weak_stretches.h"

// Where a compiled map is weak, in which direction, why, and what would help: from the map alone.
// Definitions: schemas/definitions.md, "Weak stretches".

namespace sightline {

struct WeaknessOptions {
  WeakStretchOptions stretches;
  AdviceOptions advice;
  std::size_t most = 10;         // stretches that are explained: the worst
  std::size_t judged_sites = 5;  // of a stretch, for advice: the worst and others, evenly
};

// The horizontal direction of a site's pose that the match holds least.
struct LooseDirection {
  double heading_deg = 0.0;   // from map +x, in [0, 180)
  double off_road_deg = 0.0;  // 0: along the road
  double std_m = 0.0;         // crlb_max: ranks places, is no accuracy
  double strong_std_m = 0.0;  // crlb_min
  double yaw_rad = 0.0;       // crlb_yaw
  bool is_of_map = false;     // the map's own factors; false: cast on its NDs
};

struct ExplainedStretch {
  WeakStretch stretch;
  LooseDirection loose;  // of the worst site, at the range of its best look
  UprightSights sights;  // likewise
  std::optional<double> rival_score;
  WeakCause cause = WeakCause::kUnclear;
  std::vector<TargetAdvice> advice;  // the best first
};

struct Weakness {
  double limit_m = 0.0;
  WeaknessOptions options;
  double route_m = 0.0;  // sites times their spacing
  double weak_m = 0.0;   // the same of sites in weak stretches
  double unmet_m = 0.0;  // of unmet sites
  std::size_t stretch_count = 0;
  std::vector<ExplainedStretch> stretches;  // the worst of them, the worst first
  std::size_t thinnest_site = 0;            // of the least margin, weak or not
  BestLook thinnest;
};

// Errors: bad-argument (no limit of the map, no place between nearest and farthest, or a map
// without sites).
Result<Weakness> find_weakness(PassContext& ctx, const WeaknessOptions& options,
                               const CompiledMap& map);

}  // namespace sightline
