#pragma once

#include <string_view>

#include "examples/town/drive/drive.h"
#include "tests/support/value_of.h"

namespace sightline::town {

inline TownOptions hard_options(std::string_view world, double length_m, std::uint64_t seed = 3) {
  TownOptions options{seed, length_m};
  options.world = *world_kind(world);
  return options;
}

inline Town hard_town(std::string_view world, double length_m, std::uint64_t seed = 3) {
  return value_of(make_town(hard_options(world, length_m, seed)), world);
}

// Without the town at both ends.
inline Town bare_town(std::string_view world, double length_m, std::uint64_t seed = 3) {
  TownOptions options = hard_options(world, length_m, seed);
  options.is_bare = true;
  return value_of(make_town(options), world);
}

inline DriveOptions hard_drive_options(const Town& town, std::uint64_t drive = 0) {
  return usual_drive(town.options, drive, *town_sensor(16));
}

}  // namespace sightline::town
