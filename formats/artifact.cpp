#include "formats/artifact.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "formats/base/check.h"
#include "formats/base/hash.h"

namespace sightline {
namespace {

constexpr std::array<char, 4> kMagic = {'S', 'L', 'A', '\x1a'};
constexpr std::size_t kChecksumSize = sizeof(std::uint64_t);  // behind the payload
// A head is no longer.
constexpr std::size_t kLongestHead =
    kMagic.size() + sizeof(std::uint32_t) + 2 * sizeof(std::uint64_t) + 256;

// What precedes the payload.
std::vector<std::byte> head_of(std::string_view name, std::uint32_t version, std::uint64_t size) {
  ByteWriter head;
  head.append(kMagic.data(), kMagic.size());
  head.put(version);
  head.put_string(name);
  head.put(size);
  return head.take();
}

// Whether sealed bytes of this size, which begin so, may be an artifact.
Result<void> check_magic(std::uint64_t size, std::span<const std::byte> beginning) {
  if (size < kMagic.size() + kChecksumSize) {
    return Error{ErrorCode::kTruncatedFile, concat("an artifact of ", size, " bytes is too short")};
  }
  if (std::memcmp(beginning.data(), kMagic.data(), kMagic.size()) != 0) {
    return Error{ErrorCode::kBadMagic, "not a sightline artifact", "", "byte 0"};
  }
  return {};
}

Error damaged_artifact(std::uint64_t body_size) {
  return {ErrorCode::kChecksumMismatch, "the artifact is damaged or cut short", "",
          concat("byte ", body_size)};
}

// The size of the head, which lies at the beginning of `bytes`, after its magic was seen;
// `body_size` is that of head and payload.
Result<std::size_t> check_head(std::span<const std::byte> bytes, std::uint64_t body_size,
                               std::string_view name, std::uint32_t version) {
  ByteReader reader(bytes.subspan(kMagic.size()));
  const auto found_version = reader.get<std::uint32_t>();
  std::string found_name;
  reader.get_string(found_name);
  const auto size = reader.get<std::uint64_t>();
  const std::size_t head_size = kMagic.size() + reader.offset();
  if (!reader.ok() || size != body_size - head_size) {
    return Error{ErrorCode::kTruncatedFile, "the artifact's envelope is malformed", "",
                 concat("byte ", head_size)};
  }
  if (found_name != name) {
    return Error{ErrorCode::kBadLayer, concat("found a ", found_name, ", expected a ", name)};
  }
  if (found_version != version) {
    const bool newer = found_version > version;
    return Error{newer ? ErrorCode::kFutureVersion : ErrorCode::kOldVersion,
                 concat("a ", found_name, " of version ", found_version,
                        ", this program reads version ", version)};
  }
  return head_size;
}

}  // namespace

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
  SIGHTLINE_TRY(check_magic(sealed.size(), sealed));
  const std::span<const std::byte> body = sealed.first(sealed.size() - kChecksumSize);
  std::uint64_t checksum = 0;
  std::memcpy(&checksum, sealed.data() + body.size(), kChecksumSize);
  if (checksum != xxh3(body)) return damaged_artifact(body.size());
  SIGHTLINE_ASSIGN(const std::size_t head_size, check_head(body, body.size(), name, version));
  return body.subspan(head_size);
}

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
  SIGHTLINE_ASSIGN(std::vector<std::byte> head,
                   sealed.read(0, std::min<std::uint64_t>(kLongestHead, sealed.size())));
  SIGHTLINE_TRY(check_magic(sealed.size(), head));
  const StoredBytes body = sealed.part(0, sealed.size() - kChecksumSize);
  head.resize(std::min<std::uint64_t>(head.size(), body.size()));
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
