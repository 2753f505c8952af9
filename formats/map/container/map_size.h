#pragma once

#include <cstdint>

#include "formats/record/fields.h"

namespace sightline {

// How much a map keeps: everything as it was computed, or only what its promise needs, rounded
// ("Small maps" in schemas/definitions.md).
enum class MapSize : std::uint8_t { kFull, kPromise };
template <>
inline constexpr auto kNamesOf<MapSize> = enum_names("full", "promise");

}  // namespace sightline
