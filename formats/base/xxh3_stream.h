#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace sightline {

// xxh3() of bytes that come piece by piece.
class Xxh3Stream {
 public:
  Xxh3Stream();
  ~Xxh3Stream();
  Xxh3Stream(const Xxh3Stream&) = delete;
  Xxh3Stream& operator=(const Xxh3Stream&) = delete;

  void add(std::span<const std::byte> bytes);
  [[nodiscard]] std::uint64_t finish() const;

 private:
  void* state_;  // XXH3_state_t
};

}  // namespace sightline
