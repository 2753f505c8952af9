#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace sightline {

struct Seed {
  std::string name;  // "map/seed_plain"
  std::vector<std::byte> bytes;
};

// Bags, poses, lanes, Apollo's maps, configurations and rules of the gate.
void add_foreign_seeds(std::vector<Seed>& seeds);
// Captures of Velodyne's, Ouster's and Hesai's sensors with what lies beside them.
void add_lidar_seeds(std::vector<Seed>& seeds);
// MCAP files without checksums, so that what chunks hold can be mutated, and .db3.
void add_ros2_seeds(std::vector<Seed>& seeds);

inline void add_seed(std::vector<Seed>& seeds, const std::string& name, const std::string& text) {
  Seed seed{name, {}};
  for (const char c : text) seed.bytes.push_back(static_cast<std::byte>(c));
  seeds.push_back(std::move(seed));
}

// The first byte tells a target what the rest is.
inline void add_seed(std::vector<Seed>& seeds, const std::string& name, char kind,
                     const std::string& text) {
  add_seed(seeds, name, std::string(1, kind) + text);
}

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
