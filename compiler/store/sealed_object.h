#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "formats/base/hash.h"
#include "formats/base/result.h"

namespace sightline {

// What an object of the store is: made by whom ("build-ndt", "measure-error part 12"), from what.
struct ObjectName {
  std::string kind;
  Digest key{};
  friend bool operator==(const ObjectName&, const ObjectName&) = default;
};

struct SealedObject {
  ObjectName name;
  std::span<const std::byte> content;  // within the sealed bytes
};

// What follows the content in a sealed object: the kind, then little-endian the key, u64 length of
// the content, u32 length of the kind, SHA-256 of all before it, magic "SLO\x1a". It shows damage,
// and objects that lie where others belong; who may write to the store can seal anything.
std::vector<std::byte> seal_of(const ObjectName& name, std::span<const std::byte> content);

// Errors: bad-magic, out-of-bounds, digest-mismatch.
Result<SealedObject> open_object(std::span<const std::byte> sealed);

}  // namespace sightline
