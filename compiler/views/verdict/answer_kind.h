#pragma once

#include <cstdint>

#include "formats/record/fields.h"

namespace sightline {

// What a vehicle localizes by, the recommended one first.
enum class AnswerKind : std::uint8_t { kPlan, kLook, kRange };
template <>
inline constexpr auto kNamesOf<AnswerKind> = enum_names("plan", "look", "range");

}  // namespace sightline
