#include "formats/artifact_in_pieces.h"

#include <algorithm>

#include "formats/artifact_head.h"
#include "formats/base/check.h"
#include "formats/base/hash.h"

namespace sightline {

Result<void> seal_in_pieces(std::string_view name, std::uint32_t version,
                            const PayloadInPieces& payload, const ByteSink& sink) {
  Xxh3Stream checksum;
  std::uint64_t size = 0;
  const auto take = [&](std::span<const std::byte> piece) -> Result<void> {
    checksum.add(piece);
    size += piece.size();
    return sink(piece);
  };
  const std::vector<std::byte> head = head_of(name, version, payload.size);
  SIGHTLINE_TRY(take(head));
  SIGHTLINE_TRY(payload.visit(take));
  SIGHTLINE_CHECK(size == head.size() + payload.size);
  const std::uint64_t tail = checksum.finish();
  return sink(std::as_bytes(std::span(&tail, 1)));
}

Result<StoredBytes> unseal(const StoredBytes& sealed, std::string_view name,
                           std::uint32_t version) {
  if (sealed.size() < kLeastSealed) return too_short_to_be_sealed(sealed.size());
  const StoredBytes body = sealed.part(0, sealed.size() - kChecksumSize);
  SIGHTLINE_ASSIGN(const std::vector<std::byte> head,
                   body.read(0, std::min<std::uint64_t>(kLongestHead, body.size())));
  if (!has_magic(head)) return not_sealed();
  Xxh3Stream checksum;
  SIGHTLINE_TRY(body.visit([&](std::span<const std::byte> piece) -> Result<void> {
    checksum.add(piece);
    return {};
  }));
  std::uint64_t found = 0;
  SIGHTLINE_TRY(sealed.read(body.size(), std::as_writable_bytes(std::span(&found, 1))));
  if (checksum.finish() != found) return damaged_artifact(body.size());
  SIGHTLINE_ASSIGN(const std::size_t head_size, check_head(head, body.size(), name, version));
  return body.part(head_size, body.size() - head_size);
}

Result<std::optional<std::uint64_t>> decode_front(const StoredBytes& payload,
                                                  const std::function<void(ByteReader&)>& decode) {
  // Most fronts are short; that of many sites may be long.
  constexpr std::uint64_t kShort = std::uint64_t{1} << 16;
  for (std::uint64_t size = kShort;; size *= 2) {
    const std::uint64_t read = std::min(payload.size(), size);
    SIGHTLINE_ASSIGN(const std::vector<std::byte> bytes, payload.read(0, read));
    ByteReader reader(bytes);
    decode(reader);
    if (reader.ok()) return std::optional<std::uint64_t>(reader.offset());
    if (read == payload.size()) return std::optional<std::uint64_t>();
  }
}

}  // namespace sightline
