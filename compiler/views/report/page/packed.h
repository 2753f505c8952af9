#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

// How arrays lie in the page: see page_data.h.

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

}  // namespace sightline
