#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <ranges>
#include <string_view>
#include <type_traits>

// A struct lists its fields once, behind its definition, in the order of its definition:
//
//   struct TileKey {
//     std::int32_t x = 0;
//     std::int32_t y = 0;
//   };
//   SIGHTLINE_FIELDS(TileKey, x, y)
//
// This defines fields(visit, key), which calls visit("x", key.x) and visit("y", key.y). Encoding
// (record/codec.h), cells and facts of tables (record/cells.h), what `diff` compares and checks for
// finite numbers follow from it. A field that is missing from the list does not compile.
// SIGHTLINE_SOME_FIELDS is for a struct with members that are no part of its value.

namespace sightline {

// Record or const Record.
template <class T, class Record>
concept RecordOf = std::same_as<std::remove_const_t<T>, Record>;

// A visitor that takes fields of every type.
struct AnyField {
  template <class T>
  void operator()(std::string_view, T&) {}
};

template <class T>
concept HasFields = requires(T& record, AnyField& visit) {
  fields(visit, record);
};

// An enum lists the names of its values once, behind its definition, from 0 on:
//
//   enum class LookMode : std::uint8_t { kSearch, kSettle };
//   template <>
//   inline constexpr auto kNamesOf<LookMode> = enum_names("search", "settle");
//
// Tables print a value by name, and a decoder refuses a value without one.
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

// Whether all floating-point numbers of a record are finite, those of its vectors,
// optionals and of records within it too.
template <class T>
bool are_finite(const T& value) {
  bool is_finite = true;
  if constexpr (std::is_floating_point_v<T>) {
    is_finite = std::isfinite(value);
  } else if constexpr (HasFields<T>) {
    const auto visit = [&](std::string_view /*name*/, const auto& field) {
      is_finite = is_finite && are_finite(field);
    };
    fields(visit, value);
  } else if constexpr (requires { value.allFinite(); }) {  // a matrix
    is_finite = value.allFinite();
  } else if constexpr (requires { value.has_value(); }) {
    is_finite = !value || are_finite(*value);
  } else if constexpr (std::ranges::range<const T>) {
    is_finite = std::ranges::all_of(value, [](const auto& each) { return are_finite(each); });
  }
  return is_finite;
}

}  // namespace sightline

#define SIGHTLINE_FIELDS(Record, ...)                                                        \
  void fields(auto& sightline_visit, ::sightline::RecordOf<Record> auto& sightline_record) { \
    [[maybe_unused]] auto& [__VA_ARGS__] = sightline_record; /* all there are */             \
    SIGHTLINE_EACH(SIGHTLINE_FIELD, __VA_ARGS__)                                             \
  }
#define SIGHTLINE_SOME_FIELDS(Record, ...)                                                   \
  void fields(auto& sightline_visit, ::sightline::RecordOf<Record> auto& sightline_record) { \
    SIGHTLINE_EACH(SIGHTLINE_FIELD, __VA_ARGS__)                                             \
  }

// What they are made of. SIGHTLINE_EACH(macro, a, b) is macro(a) macro(b), for up to 64 arguments:
// each expansion of the outer macro expands the inner one once more.
#define SIGHTLINE_FIELD(name) sightline_visit(#name, sightline_record.name);
#define SIGHTLINE_EACH(macro, ...) \
  __VA_OPT__(SIGHTLINE_EXPAND(SIGHTLINE_EACH_STEP(macro, __VA_ARGS__)))
#define SIGHTLINE_EACH_STEP(macro, first, ...) \
  macro(first) __VA_OPT__(SIGHTLINE_EACH_AGAIN SIGHTLINE_PARENTHESES(macro, __VA_ARGS__))
#define SIGHTLINE_EACH_AGAIN() SIGHTLINE_EACH_STEP
#define SIGHTLINE_PARENTHESES ()
#define SIGHTLINE_EXPAND(...) \
  SIGHTLINE_EXPAND_4(SIGHTLINE_EXPAND_4(SIGHTLINE_EXPAND_4(SIGHTLINE_EXPAND_4(__VA_ARGS__))))
#define SIGHTLINE_EXPAND_4(...) \
  SIGHTLINE_EXPAND_1(SIGHTLINE_EXPAND_1(SIGHTLINE_EXPAND_1(SIGHTLINE_EXPAND_1(__VA_ARGS__))))
#define SIGHTLINE_EXPAND_1(...) \
  SIGHTLINE_EXPAND_0(SIGHTLINE_EXPAND_0(SIGHTLINE_EXPAND_0(SIGHTLINE_EXPAND_0(__VA_ARGS__))))
#define SIGHTLINE_EXPAND_0(...) __VA_ARGS__
