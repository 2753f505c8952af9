#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

// How arrays lie in the page: see page_data.md.

namespace sightline {

// Base64 of a zlib stream (RFC 1950) of the bytes by planes: the first byte of every element, then
// the second of every element, and so on, which packs numbers better. Elements of 1 byte lie as
// they are.
std::string packed(std::span<const std::byte> bytes, std::size_t element_size);

template <class T>
std::string packed(const std::vector<T>& values) {
  return packed(std::as_bytes(std::span(values)), sizeof(T));
}
inline std::string packed(std::string_view text) {
  return packed(std::as_bytes(std::span(text)), 1);
}

// A number as a float of four significant digits, for what is looked at and not reckoned with:
// its last bits are 0 and pack to nothing.
float four_digits(double value);

using PageJson = nlohmann::ordered_json;

template <class T>
constexpr const char* type_name() {
  if (sizeof(T) == 1) return "u8";
  if (sizeof(T) == 2) return "u16";
  if (std::is_floating_point_v<T>) return sizeof(T) == 4 ? "f32" : "f64";
  return "u32";
}

// An array of page_data.md.
template <class T>
PageJson json_numbers(const std::vector<T>& values) {
  return {{"type", type_name<T>()}, {"count", values.size()}, {"data", packed(values)}};
}

}  // namespace sightline
