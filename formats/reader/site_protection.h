#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "formats/base/result.h"
#include "formats/reader/protection_table.h"
#include "formats/reader/reader.h"

namespace sightline {

// Bounds of the errors of a vehicle that tracks, before any match: m and rad, in the vehicle's
// axes.
struct SiteProtection {
  ProtectionFactors levels = {kUnavailable, kUnavailable, kUnavailable, kUnavailable};
  std::uint32_t place_kind = 0;   // the map's column of that name; 0: unknown
  std::uint32_t block_count = 0;  // of 60 m that calibrated the levels
};

// Each level is the bound of the kind of place, or the site's own measured error times the factor
// of its kind, if that is larger.
SiteProtection site_protection(std::uint32_t place_kind, const PoseErrors& own, double risk);

// Refers into the map.
class MapProtection {
 public:
  MapProtection(MapColumn kinds, MapErrors errors);

  // site_protection() at RangeAnswer::site, for a risk per 60 m and axis. The measured error is
  // that of the longest range, or of a look that takes a sample.
  [[nodiscard]] SiteProtection at(std::uint32_t site, double risk = 0.01,
                                  bool is_sample = false) const;

 private:
  MapColumn kinds_;
  MapErrors errors_;
};

// Look up once and keep it. Errors: those of MapReader::column().
Result<MapProtection> protection_of(const MapReader& map);

}  // namespace sightline
