#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "formats/grid/site_shape.h"
#include "formats/model/place_kind.h"
#include "passes/model/promise/selection.h"

// One look for each kind of place (schemas/definitions.md, "Looks of kinds of place"). Looks differ
// between kinds of place, and hardly between the sites of one kind.

namespace sightline {

// Of the map's own scans or of a localization drive.
struct LookErrors {
  std::vector<double> error_m;            // [site][look]
  std::vector<std::uint8_t> is_measured;  // [site]
};

struct LookEvidence {
  SiteShape shape;           // of looks
  std::vector<double> cost;  // [look], of one match
  std::vector<PlaceKind> kinds;
  std::vector<RoutePoint> route;
  LookErrors own;                  // of the map's own scans
  std::vector<LookErrors> drives;  // that were localized here; may be none
  bool is_simulated = false;       // no scan of a drive is behind `own`
};

// Indices of looks.
struct KindLooks {
  std::uint8_t everywhere = 0;  // the best constant
  std::array<std::uint8_t, kPlaceKindCount> of_kind{};
  double coverage = 0.0;  // share of sites within the limit by these looks

  [[nodiscard]] std::uint8_t at(PlaceKind kind) const {
    return of_kind[static_cast<std::size_t>(kind)];
  }
};

// The share of a kind's sites that miss the limit by a look is that of the own scans or that of the
// drives, whichever is larger. Kinds where no look covers 80 % take the one that covers most, and
// are not counted further, unless no kind has such a look. The best constant is the cheapest look
// with at most `miss_share` misses over the counted sites; where there is none, the one of fewest
// misses. Kinds take other looks only together: those of least cost whose misses, added up, are no
// more than the constant's (by a Lagrange multiplier). And only where that is proven: looks chosen
// on every second block of 30 m of route are judged on the others, and the other way round; there
// they must cost less by more than a twentieth, and the sum of cost and weighted misses, paired by
// block, must be lower at a level of 5 %. Simulated errors prove nothing.
KindLooks choose_kind_looks(const LookEvidence& evidence, double limit_m, double miss_share);

}  // namespace sightline
