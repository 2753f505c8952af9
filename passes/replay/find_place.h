#pragma once

#include <optional>

#include "formats/drive/drive.h"
#include "passes/replay/place_check.h"
#include "passes/replay/place_finder.h"
#include "passes/vehicle/vehicle_localizer.h"

namespace sightline {

// What a search looks in.
struct SearchedMap {
  const VehicleLocalizer& localizer;
  const PlaceCheck& check;
  const PlaceFinder& finder;
  MapLook look;  // of the matches that decide
};

// The likeliest place of a scan.
struct FoundPlace {
  sightline_match match{};
  double met_share = 0.0;   // of its upright points (PlaceCheck)
  double likelihood = 0.0;  // mean over points: of the map near each (nearest_voxel_likelihood)
  // Of the best match that is another place: more than a match's error away (are_elsewhere).
  double likelihood_elsewhere = 0.0;
};

// Whether it is as likely as right places are, and no other place is nearly as likely.
bool is_sure(const FoundPlace& place);

// The likelier one of two that were found for one scan in two maps; of equals the first. It knows
// of the other where that is another place, else of what is elsewhere in the other map.
FoundPlace likelier_of(const FoundPlace& first, const FoundPlace& second);

// Matches a scan from all likely places of a map. `upright_m`: upright_of(scan). None where no
// place is likely or no match is good. The same for any number of threads. Errors: those of
// VehicleLocalizer::match.
Result<std::optional<FoundPlace>> find_place(const SearchedMap& map, const Scan& scan,
                                             const std::vector<Eigen::Vector3d>& upright_m,
                                             int threads);

}  // namespace sightline
