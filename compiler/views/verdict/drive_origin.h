#pragma once

#include <algorithm>
#include <cstdint>
#include <string_view>

#include "formats/record/fields.h"

namespace sightline {

// What the drive of an evaluation has to do with the map that it judges ("Identity of recordings"
// in schemas/definitions.md).
enum class DriveOrigin : std::uint8_t {
  kOther,       // neither map, errors nor model were made from it
  kOwn,         // they were; as files of earlier programs name it
  kOtherScans,  // it made the map, and scans of it that made no ND judge
  kKnown,       // map, errors or model were made from it: judged with --allow-known-drive
  kUnknown      // the map or its model does not list the scans of its recordings
};
template <>
inline constexpr auto kNamesOf<DriveOrigin> = enum_names("other", "own", "same-drive-other-scans",
                                                         "known", "unknown");

// Whether figures on the drive are optimistic.
constexpr bool is_own(DriveOrigin origin) {
  return origin == DriveOrigin::kOwn || origin == DriveOrigin::kOtherScans ||
         origin == DriveOrigin::kKnown;
}

// kUnknown for a name that none has: files of earlier programs do not say.
constexpr DriveOrigin origin_named(std::string_view name) {
  const auto found = std::ranges::find(kNamesOf<DriveOrigin>, name);
  if (found == kNamesOf<DriveOrigin>.end()) return DriveOrigin::kUnknown;
  return static_cast<DriveOrigin>(found - kNamesOf<DriveOrigin>.begin());
}

}  // namespace sightline
