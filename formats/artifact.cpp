#include "formats/artifact.h"

#include "formats/artifact_head.h"
#include "formats/base/hash.h"

namespace sightline {

// Within the payload's own memory, as far as it suffices: an artifact may be a large part of what
// there is.
std::vector<std::byte> seal(std::string_view name, std::uint32_t version,
                            std::vector<std::byte> payload) {
  const std::vector<std::byte> head = head_of(name, version, payload.size());
  std::vector<std::byte> sealed = std::move(payload);
  sealed.reserve(sealed.size() + head.size() + kChecksumSize);
  sealed.insert(sealed.begin(), head.begin(), head.end());
  const std::uint64_t checksum = xxh3(sealed);
  const auto* const tail = reinterpret_cast<const std::byte*>(&checksum);
  sealed.insert(sealed.end(), tail, tail + sizeof checksum);
  return sealed;
}

Result<std::span<const std::byte>> unseal(std::span<const std::byte> sealed, std::string_view name,
                                          std::uint32_t version) {
  if (sealed.size() < kLeastSealed) return too_short_to_be_sealed(sealed.size());
  if (!has_magic(sealed)) return not_sealed();
  const std::span<const std::byte> body = sealed.first(sealed.size() - kChecksumSize);
  std::uint64_t checksum = 0;
  std::memcpy(&checksum, sealed.data() + body.size(), kChecksumSize);
  if (checksum != xxh3(body)) return damaged_artifact(body.size());
  SIGHTLINE_ASSIGN(const std::size_t head_size, check_head(body, body.size(), name, version));
  return body.subspan(head_size);
}

}  // namespace sightline
