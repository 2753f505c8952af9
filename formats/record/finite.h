#pragma once

#include <algorithm>
#include <cmath>
#include <ranges>
#include <string_view>
#include <type_traits>

#include "formats/record/fields.h"

namespace sightline {

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
