#include "passes/map/places/field_limits.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "formats/text/table.h"

namespace sightline {
namespace {

constexpr const char* kPlace = "pass choose-field-sites";
constexpr double kKibOfMib = 1024.0;
constexpr double kMibOfGib = 1024.0;

// Measured on squares of 5 193 to 39 000 places: of each place, of a square metre of the raster
// of free ground, and beside them.
constexpr double kMemoryOfPlace_kib = 6.5;
constexpr double kMemoryOfGround_kib = 1.1;
constexpr double kLeastMemory_mib = 200.0;

double room_kib(const ChooseFieldSitesOptions& options) {
  return std::max(0.0, options.memory_gib * kMibOfGib - kLeastMemory_mib) * kKibOfMib;
}

double most_places(const ChooseFieldSitesOptions& options) {
  if (options.most_places > 0) return options.most_places;
  return std::floor(room_kib(options) / kMemoryOfPlace_kib);
}

}  // namespace

double memory_of_places_mib(double count) {
  return kLeastMemory_mib + count * kMemoryOfPlace_kib / kKibOfMib;
}

Result<void> check_ground(double ground_m2, const ChooseFieldSitesOptions& options) {
  if (ground_m2 * kMemoryOfGround_kib <= room_kib(options)) return {};
  const double needed_mib = kLeastMemory_mib + ground_m2 * kMemoryOfGround_kib / kKibOfMib;
  char text[256];
  std::snprintf(
      text, sizeof text,
      "found ground of %.1f km^2, which needs about %.1f GiB, more than the limit of %s GiB "
      "(choose-field-sites.memory_gib): annotate a part of the map (within), or raise the limit",
      1e-6 * ground_m2, needed_mib / kMibOfGib, format_double(options.memory_gib).c_str());
  return Error{ErrorCode::kTooManyPlaces, text, "", kPlace};
}

Result<void> check_places(std::size_t count, const ChooseFieldSitesOptions& options) {
  const double places = static_cast<double>(count);
  if (places <= most_places(options)) return {};
  const std::string asked_for = options.most_places > 0
                                    ? "are allowed (choose-field-sites.most_places)"
                                    : concat("fit in ", format_double(options.memory_gib),
                                             " GiB (choose-field-sites.memory_gib)");
  char text[400];
  std::snprintf(text, sizeof text,
                "found %zu places, %.4g m apart, but at most %.0f %s. They need about %.1f GiB of "
                "memory and %.1f hours of one core: choose a part of the map (within) or a wider "
                "spacing_m, or raise the limit",
                count, options.spacing_m, most_places(options), asked_for.c_str(),
                memory_of_places_mib(places) / kMibOfGib, places * kCpuOfPlace_s / 3600.0);
  return Error{ErrorCode::kTooManyPlaces, text, "", kPlace};
}

}  // namespace sightline
