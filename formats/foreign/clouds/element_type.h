#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace sightline {

enum class ElementKind { kSigned, kUnsigned, kFloat };

// A number as it lies in a binary file. Sizes: 1, 2, 4, 8; float 4 or 8.
struct ElementType {
  ElementKind kind = ElementKind::kFloat;
  std::size_t size = 4;
};

template <class T>
double read_as(const std::uint8_t* bytes) {
  T value{};
  std::memcpy(&value, bytes, sizeof value);
  return static_cast<double>(value);
}

// Little-endian, any alignment. 64-bit integers beyond 2^53 are rounded.
inline double read_element(const std::uint8_t* bytes, ElementType type) {
  if (type.kind == ElementKind::kFloat) {
    return type.size == 4 ? read_as<float>(bytes) : read_as<double>(bytes);
  }
  const bool is_signed = type.kind == ElementKind::kSigned;
  switch (type.size) {
    case 1:
      return is_signed ? read_as<std::int8_t>(bytes) : read_as<std::uint8_t>(bytes);
    case 2:
      return is_signed ? read_as<std::int16_t>(bytes) : read_as<std::uint16_t>(bytes);
    case 4:
      return is_signed ? read_as<std::int32_t>(bytes) : read_as<std::uint32_t>(bytes);
    default:
      return is_signed ? read_as<std::int64_t>(bytes) : read_as<std::uint64_t>(bytes);
  }
}

// The same from a file of the other byte order.
inline double read_big_endian_element(const std::uint8_t* bytes, ElementType type) {
  std::uint8_t turned[8] = {};
  std::reverse_copy(bytes, bytes + type.size, turned);
  return read_element(turned, type);
}

}  // namespace sightline
