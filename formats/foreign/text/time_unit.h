#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sightline {

// Times that were read as seconds but are whole numbers of a finer unit: half of the steps between
// them are 20 s or more, so that no drive was recorded at them. Divides them so that the middle
// step is below, and returns the unit: "milliseconds", "microseconds" or "nanoseconds"; "" where
// they stay. `stamps_ns` are ascending.
std::string take_finer_unit(std::vector<std::int64_t>& stamps_ns);

}  // namespace sightline
