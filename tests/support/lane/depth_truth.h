#pragma once

#include <functional>
#include <vector>

#include "formats/annotation/sites.h"
#include "formats/surroundings/site_views.h"
#include "tests/support/lane/lane.h"

namespace sightline::lane {

// One ray of a depth image, and what is there; +inf where nothing is within the image's range.
struct TrueRay {
  double range_m = 0.0;
  double elevation_deg = 0.0;
  Kind kind = Kind::kGround;       // of what is hit; kGround where nothing is
  bool is_through_leaves = false;  // hits leaves, or passes them closely on its way
};

// Sites between the scans of a drive along the lane.
Sites sites_along(const Lane& lane, double length_m, double spacing_m);

// As the cells of `images` lie, whose distances are not looked at.
std::vector<TrueRay> true_rays(const Lane& lane, const Caster& caster, const Sites& sites,
                               const DepthImages& images);

struct Fidelity {
  std::size_t rays = 0;
  double agreement = 0.0;  // share of rays on which both hit or both miss
  double median_m = 0.0;   // of the distance's error where both hit
  double p95_m = 0.0;
  double nearer = 0.0;   // share of rays found over 0.5 m nearer than the truth, a miss being far
  double farther = 0.0;  // ... farther
};

Fidelity fidelity_of(const DepthImages& images, const std::vector<TrueRay>& truth,
                     const std::function<bool(const TrueRay&)>& counts);

}  // namespace sightline::lane
