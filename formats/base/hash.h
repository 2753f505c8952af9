#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace sightline {

// SHA-256 (FIPS 180-4): names contents.
using Digest = std::array<std::uint8_t, 32>;

Digest sha256(std::span<const std::byte> bytes);
Digest sha256(std::string_view text);
std::string to_hex(const Digest& digest);

// XXH3, 64 bits, seed 0: detects damage, is no proof against intent.
std::uint64_t xxh3(std::span<const std::byte> bytes);

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

// SHA-256 of bytes that come piece by piece: the same as sha256() of all of them.
class Sha256Stream {
 public:
  Sha256Stream();
  ~Sha256Stream();
  Sha256Stream(const Sha256Stream&) = delete;
  Sha256Stream& operator=(const Sha256Stream&) = delete;

  void add(std::span<const std::byte> bytes);
  Digest finish();

 private:
  void* state_;  // EVP_MD_CTX
};

// SHA-256 of parts of which each is preceded by its length, so that no two lists of parts collide.
class DigestBuilder {
 public:
  void add(std::string_view part);
  void add(std::span<const std::byte> part);
  void add(const Digest& part);
  Digest finish() { return stream_.finish(); }

 private:
  Sha256Stream stream_;
};

// Names what is made of something named `source` in a way that `kind` and `values` tell.
Digest derived_digest(std::string_view kind, const Digest& source,
                      std::span<const std::byte> values);

}  // namespace sightline
