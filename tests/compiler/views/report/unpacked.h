#pragma once

#include <zlib.h>

#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

// Reads what compiler/views/report/page/packed.h writes, by other means.

namespace sightline {

inline std::vector<unsigned char> bytes_of_base64(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<unsigned char> bytes;
  unsigned bits = 0;
  unsigned count = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = bits << 6U | static_cast<unsigned>(digits.find(c));
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes.push_back(static_cast<unsigned char>(bits >> count & 255U));
  }
  return bytes;
}

inline std::vector<unsigned char> inflated(const std::string& text, std::size_t most) {
  const std::vector<unsigned char> stream = bytes_of_base64(text);
  std::vector<unsigned char> bytes(most);
  uLongf size = most;
  if (uncompress(bytes.data(), &size, stream.data(), stream.size()) != Z_OK) return {};
  bytes.resize(size);
  return bytes;
}

template <class T>
std::vector<T> unpacked(const nlohmann::json& packed) {
  const std::size_t count = packed.at("count").get<std::size_t>();
  std::vector<T> values(count);
  const std::vector<unsigned char> planes =
      inflated(packed.at("data").get<std::string>(), count * sizeof(T) + 1);
  if (planes.size() != count * sizeof(T)) return {};
  for (std::size_t i = 0; i < count; ++i) {
    unsigned char bytes[sizeof(T)];
    for (std::size_t plane = 0; plane < sizeof(T); ++plane)
      bytes[plane] = planes[plane * count + i];
    std::memcpy(&values[i], bytes, sizeof(T));
  }
  return values;
}

}  // namespace sightline
