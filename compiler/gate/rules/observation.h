#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/result.h"

namespace sightline {

// How the ranges of the map fared on a drive at one limit (RuleScore of the map's own rule).
struct ObservedLimit {
  double limit_m = 0.0;
  double coverage = 0.0;
  double mean_range_m = 0.0;
  double time_ratio = 0.0;  // to the longest range
  double work_ratio = 0.0;
  double worst_coverage = 0.0;  // of the worst stretch
  std::uint32_t worst_begin_site = 0;
};

// What `sightline evaluate --json` wrote, as far as the gate judges it.
struct Observation {
  std::string drive;
  std::uint32_t site_count = 0;  // of the map
  double stretch_m = 0.0;        // length of the worst stretch
  std::vector<ObservedLimit> limits;
};

// Errors: file-not-found, cannot-open, cannot-read, malformed-text (no JSON of evaluate's).
Result<Observation> read_observation(const std::filesystem::path& file);
Result<Observation> parse_observation(std::string_view json);

}  // namespace sightline
