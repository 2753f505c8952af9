#include "formats/model/street_type.h"

#include <algorithm>
#include <limits>

namespace sightline {
namespace {

// Walls of a lane are so near that two thirds of all that a site sees lies within this.
constexpr double kLane_m = 10.0;
constexpr double kLaneShare = 2.0 / 3.0;
// Half of what a site sees lies within these; it grows with the distance of the facades.
constexpr double kHalfShare = 0.5;
constexpr double kCanyon_m = 15.0;
constexpr double kCrossing_m = 20.0;
constexpr double kAvenue_m = 30.0;
// A street closes the view but for its two ends; where less than this is closed, streets leave it.
constexpr double kClosedShare = 0.8;

// The shortest range within which a share of the depth image is hit; infinity where none is.
double range_of_share(const FactorTable& factors, std::size_t site, std::size_t occupancy,
                      double share) {
  for (std::size_t range = 0; range < factors.looks.size(); ++range) {
    if (factors.at(site, range, occupancy) >= share) return factors.looks[range].range_m;
  }
  return std::numeric_limits<double>::infinity();
}

StreetType type_of(const FactorTable& factors, std::size_t site, std::size_t occupancy) {
  if (range_of_share(factors, site, occupancy, kLaneShare) <= kLane_m) return StreetType::kLane;
  const double half_m = range_of_share(factors, site, occupancy, kHalfShare);
  const double closed = factors.at(site, factors.looks.size() - 1, occupancy);
  if (half_m <= kCrossing_m && closed < kClosedShare) return StreetType::kCrossing;
  if (half_m <= kCanyon_m) return StreetType::kCanyon;
  return half_m <= kAvenue_m ? StreetType::kAvenue : StreetType::kOpen;
}

}  // namespace

std::vector<StreetType> street_types(const FactorTable& factors) {
  std::vector<StreetType> types(factors.site_count, StreetType::kUnknown);
  const auto found = std::ranges::find(factors.factors, "occupancy_ratio");
  if (found == factors.factors.end()) return types;
  const auto occupancy = static_cast<std::size_t>(found - factors.factors.begin());
  for (std::size_t site = 0; site < types.size(); ++site) {
    types[site] = type_of(factors, site, occupancy);
  }
  return types;
}

}  // namespace sightline
