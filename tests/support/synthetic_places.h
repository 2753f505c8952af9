#pragma once

#include <string>
#include <utility>

#include "compiler/base/random.h"
#include "formats/driven_places.h"
#include "tests/support/synthetic_drive.h"

namespace sightline {

// A synthetic place (tests/support/synthetic_drive.h) that was driven twice: the second drive finds
// what the first found, but for noise of its own.
inline DrivenPlace place_driven_twice(std::uint64_t seed, const SyntheticOptions& options) {
  SyntheticDrive drive = synthetic_drive(seed, options);
  MeasuredError again = drive.measured;
  again.drive = "again";
  Random random(mix(seed, 77));
  for (ErrorRow& row : again.rows) row.mean_m *= std::exp(0.1 * random.normal());
  return {"place " + std::to_string(seed), std::move(drive.sites), std::move(drive.factors),
          {std::move(drive.measured), std::move(again)}};
}

inline DrivenPlaces places_driven_twice(std::size_t count, const SyntheticOptions& options) {
  DrivenPlaces places;
  for (std::size_t i = 0; i < count; ++i) {
    places.places.push_back(place_driven_twice(i + 1, options));
  }
  return places;
}

}  // namespace sightline
