#pragma once

#include <optional>
#include <span>
#include <vector>

#include "formats/base/hash.h"

namespace sightline {

// Keeps what was read of scan files from one run to the next, under a key that names in which state
// the files were then.
class DigestMemory {
 public:
  virtual ~DigestMemory() = default;
  // Nothing where nothing is known.
  [[nodiscard]] virtual std::optional<std::vector<std::byte>> load(const Digest& key) const = 0;
  // What cannot be kept is read again by the next run, so that is not reported.
  virtual void store(const Digest& key, std::span<const std::byte> content) const = 0;
};

}  // namespace sightline
