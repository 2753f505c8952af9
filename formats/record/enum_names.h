#pragma once

#include <array>
#include <cstddef>
#include <string_view>
#include <type_traits>

// An enum lists the names of its values once, behind its definition, from 0 on:
//
//   enum class LookMode : std::uint8_t { kSearch, kSettle };
//   template <>
//   inline constexpr auto kNamesOf<LookMode> = enum_names("search", "settle");
//
// Tables print a value by name, and a decoder refuses a value without one.

namespace sightline {

template <class... Names>
constexpr std::array<std::string_view, sizeof...(Names)> enum_names(Names... names) {
  return {names...};
}

template <class Enum>
inline constexpr std::array<std::string_view, 0> kNamesOf = {};

template <class Enum>
concept NamedEnum = std::is_enum_v<Enum> && !kNamesOf<Enum>.empty();

// Empty for a number that is no value of the enum.
template <NamedEnum Enum>
constexpr std::string_view name_of(Enum value) {
  const auto number = static_cast<std::size_t>(value);
  return number < kNamesOf<Enum>.size() ? kNamesOf<Enum>[number] : std::string_view();
}

}  // namespace sightline
