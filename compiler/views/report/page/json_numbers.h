#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>
#include <vector>

#include "compiler/views/report/page/packed.h"
#include "compiler/views/report/page/page_data.h"

namespace sightline {

template <class T>
constexpr const char* type_name() {
  if (sizeof(T) == 1) return "u8";
  if (sizeof(T) == 2) return "u16";
  if (std::is_floating_point_v<T>) return sizeof(T) == 4 ? "f32" : "f64";
  return "u32";
}

// An array of page_data.h.
template <class T>
PageJson json_numbers(const std::vector<T>& values) {
  return {{"type", type_name<T>()}, {"count", values.size()}, {"data", packed(values)}};
}

}  // namespace sightline
