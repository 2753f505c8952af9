#pragma once

#include <cstdint>

#include "formats/base/bytes.h"
#include "formats/record/fields.h"

namespace sightline {

// What poses rest on where scans do not constrain them; none: the speed before was not known.
enum class Substitute : std::uint8_t { kNone, kGivenPoses, kConstantSpeed, kWheelSpeed, kInertial };
template <>
inline constexpr auto kNamesOf<Substitute> = enum_names("none", "given-poses", "constant-speed",
                                                        "wheel-speed", "inertial");

// Of a pose: the directions of the vehicle's motion that scans do not constrain.
struct Unconstrained {
  bool along = false;  // the road
  bool across = false;
  bool heading = false;
  Substitute substitute = Substitute::kNone;

  [[nodiscard]] bool is_any() const { return along || across || heading; }
  friend bool operator==(const Unconstrained&, const Unconstrained&) = default;
};
SIGHTLINE_FIELDS(Unconstrained, along, across, heading, substitute)

}  // namespace sightline
