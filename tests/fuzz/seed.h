#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

// Inputs that a fuzzer starts from, and the bytes that they are made of.

namespace sightline {

struct Seed {
  std::string name;  // "map/seed_plain"
  std::vector<std::byte> bytes;
};

inline void add_seed(std::vector<Seed>& seeds, const std::string& name, const std::string& text) {
  Seed seed{name, {}};
  for (const char c : text) seed.bytes.push_back(static_cast<std::byte>(c));
  seeds.push_back(std::move(seed));
}

// The bytes of a number or an array.
template <class T>
std::string raw(T value) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  return bytes;
}

// A text behind its length in 32 bits.
inline std::string sized(const std::string& text) {
  return raw(static_cast<std::uint32_t>(text.size())) + text;
}

}  // namespace sightline
