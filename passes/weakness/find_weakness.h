#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "formats/model/place_kind.h"
#include "passes/weakness/advise_targets.h"
#include "passes/weakness/site_view.h"
#include "passes/weakness/weak_stretches.h"

// Where a compiled map is weak, in which direction, why, and what would help: from the map alone.
// Definitions: schemas/definitions.md, "Weak stretches".

namespace sightline {

// Why a place is weak: what the sensor sees there that could hold it, and what does not.

enum class WeakCause : std::uint8_t {
  kEmpty,     // few upright surfaces in sight
  kOneSided,  // all of them face one way: a corridor, a bare wall
  kRepeated,  // what is seen looks the same half a metre and more further along the loose direction
  kDistant,   // what holds the loose direction is far
  kUnclear    // what is seen should hold the place: the reason is not in the geometry
};
std::string_view name_of(WeakCause cause);  // "empty", "one-sided", "repeated", ...

// Upright surfaces that a scan meets: NDs of class 2 whose normal is within 30 degrees of level.
// One holds a direction where its normal is within 30 degrees of it.
struct UprightSights {
  std::size_t count = 0;
  std::size_t holding_count = 0;            // of them, those that hold the loose direction
  std::optional<double> nearest_holding_m;  // of these, from the sensor to the mean; nothing: none
  double one_sidedness = 0.0;  // 1 - least over largest eigenvalue of the summed n n^T, horizontal
                               // part, of them all; 1: all face one way; 0 where there are none
};
UprightSights upright_sights(const SiteView& view, const NearNds& nds, double loose_heading_deg);

// `rival_score` as of schemas/definitions.md, nothing where it is not known; `range_m` is how far
// was looked.
WeakCause cause_of(const UprightSights& sights, std::optional<double> rival_score, double range_m);

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
  PlaceKind kind = PlaceKind::kUnknown;  // of the worst site
  LooseDirection loose;                  // of the worst site, at the range of its best look
  UprightSights sights;                  // likewise
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
