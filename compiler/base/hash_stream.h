#pragma once

#include <cstddef>
#include <span>

#include "compiler/base/hash.h"

namespace sightline {

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

}  // namespace sightline
