#pragma once

#include <string>
#include <utility>
#include <vector>

#include "compiler/report/packed.h"
#include "formats/table.h"

// JSON made of values that are JSON texts already.

namespace sightline {

using JsonMember = std::pair<std::string, std::string>;  // name and value

inline std::string json_object(const std::vector<JsonMember>& members) {
  std::string text = "{";
  for (const JsonMember& member : members) {
    text += (text.size() == 1 ? "\"" : ",\"") + member.first + "\":" + member.second;
  }
  return text + "}";
}

inline std::string json_array(const std::vector<std::string>& values) {
  std::string text = "[";
  for (const std::string& value : values) text += (text.size() == 1 ? "" : ",") + value;
  return text + "]";
}

inline std::string json_array(const std::vector<double>& values) {
  std::vector<std::string> texts;
  for (const double value : values) texts.push_back(format_double(value));
  return json_array(texts);
}

template <class T>
constexpr const char* type_name() {
  if (sizeof(T) == 1) return "u8";
  if (sizeof(T) == 2) return "u16";
  if (std::is_floating_point_v<T>) return sizeof(T) == 4 ? "f32" : "f64";
  return "u32";
}

// An array of page_data.h.
template <class T>
std::string json_numbers(const std::vector<T>& values) {
  return json_object({{"type", "\"" + std::string(type_name<T>()) + "\""},
                      {"count", std::to_string(values.size())},
                      {"data", "\"" + packed(values) + "\""}});
}

}  // namespace sightline
