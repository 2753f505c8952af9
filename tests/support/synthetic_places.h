#pragma once

#include <string>
#include <utility>

#include "formats/annotation/driven_places.h"
#include "formats/base/random.h"
#include "tests/support/synthetic_drive.h"

namespace sightline {

// Cards of made-up recordings; other seeds, other digests.
inline RecordingCards synthetic_recordings(std::uint64_t seed) {
  const std::string name = std::to_string(seed);
  return {{{"mapping", "mapping", sha256("mapping " + name)},
           {"localization", "synthetic", sha256("synthetic " + name)}}};
}

// A synthetic drive as the one that a place was driven.
inline DrivenPlace place_of(const SyntheticDrive& drive) {
  return {
      drive.measured.drive, drive.sites, drive.factors, {drive.measured}, synthetic_recordings(0)};
}

// A synthetic place (tests/support/synthetic_drive.h) that was driven twice: the second drive finds
// what the first found, but for noise of its own.
inline DrivenPlace place_driven_twice(std::uint64_t seed, const SyntheticOptions& options) {
  SyntheticDrive drive = synthetic_drive(seed, options);
  MeasuredError again = drive.measured;
  again.drive = "again";
  Random random(mix(seed, 77));
  for (ErrorRow& row : again.rows) row.mean_m *= std::exp(0.1 * random.normal());
  RecordingCards recordings = synthetic_recordings(seed);
  recordings.cards.push_back({"evaluation", "again", sha256("again " + std::to_string(seed))});
  return {"place " + std::to_string(seed),
          std::move(drive.sites),
          std::move(drive.factors),
          {std::move(drive.measured), std::move(again)},
          std::move(recordings)};
}

// The same, driven `drive_count` times: each later drive finds what the first found, but for noise
// of its own.
inline DrivenPlace place_driven_often(std::uint64_t seed, std::size_t drive_count,
                                      const SyntheticOptions& options) {
  DrivenPlace place = place_driven_twice(seed, options);
  const MeasuredError first = place.drives.front();
  for (std::size_t drive = 2; drive < drive_count; ++drive) {
    MeasuredError& another = place.drives.emplace_back(first);
    another.drive = "drive " + std::to_string(drive + 1);
    Random random(mix(seed, 100 + drive));
    for (ErrorRow& row : another.rows) row.mean_m *= std::exp(0.1 * random.normal());
    place.recordings.cards.push_back({"localization[" + std::to_string(drive + 1) + "]",
                                      another.drive,
                                      sha256(another.drive + " of " + std::to_string(seed))});
  }
  return place;
}

inline DrivenPlaces places_driven_twice(std::size_t count, const SyntheticOptions& options) {
  DrivenPlaces places;
  for (std::size_t i = 0; i < count; ++i) {
    places.places.push_back(place_driven_twice(i + 1, options));
  }
  return places;
}

}  // namespace sightline
