#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/annotation/factor_table.h"
#include "formats/annotation/measured_error.h"
#include "formats/annotation/sites.h"
#include "formats/artifact.h"
#include "formats/drive/recording_cards.h"
#include "formats/record/fields.h"

namespace sightline {

// A mapped place that was driven once or more after it was mapped: what its map says of each site,
// and how well each drive localized there, by the looks of a family.
struct DrivenPlace {
  std::string name;
  Sites sites;
  FactorTable factors;
  std::vector<MeasuredError> drives;  // at least one; of these sites, at the factors' ranges
  RecordingCards recordings;          // that map and errors were made from
};
SIGHTLINE_FIELDS(DrivenPlace, name, sites, factors, drives, recordings)

// All that an error model is trained on.
struct DrivenPlaces {
  std::vector<DrivenPlace> places;  // at least one; all with the same ranges and factors
};
SIGHTLINE_FIELDS(DrivenPlaces, places)

template <>
struct ArtifactTraits<DrivenPlaces> {
  static constexpr std::string_view kName = "driven-places";
  static constexpr std::uint32_t kVersion = 6;
};

// Every part is valid in itself and belongs to its place. Errors: mismatched-inputs where sites,
// factors or errors of a place differ in count or ranges, or places in ranges or factors; the
// place is named.
Result<void> validate(const DrivenPlaces& places);
Table dump(const DrivenPlaces& places);  // one row per drive
Table dump(const ByFamily<DrivenPlaces>& places);

}  // namespace sightline
