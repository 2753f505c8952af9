#include "formats/artifact.h"

#include <array>

#include "formats/base/hash.h"

namespace sightline {
namespace {

constexpr std::array<char, 4> kMagic = {'S', 'L', 'A', '\x1a'};

}  // namespace

// Within the payload's own memory, as far as it suffices: an artifact may be a large part of what
// there is.
std::vector<std::byte> seal(std::string_view name, std::uint32_t version,
                            std::vector<std::byte> payload) {
  ByteWriter head;
  head.append(kMagic.data(), kMagic.size());
  head.put(version);
  head.put_string(name);
  head.put<std::uint64_t>(payload.size());
  std::vector<std::byte> sealed = std::move(payload);
  sealed.reserve(sealed.size() + head.bytes().size() + sizeof(std::uint64_t));
  sealed.insert(sealed.begin(), head.bytes().begin(), head.bytes().end());
  const std::uint64_t checksum = xxh3(sealed);
  const auto* const tail = reinterpret_cast<const std::byte*>(&checksum);
  sealed.insert(sealed.end(), tail, tail + sizeof checksum);
  return sealed;
}

Result<std::span<const std::byte>> unseal(std::span<const std::byte> sealed, std::string_view name,
                                          std::uint32_t version) {
  constexpr std::size_t kChecksumSize = sizeof(std::uint64_t);
  if (sealed.size() < kMagic.size() + kChecksumSize) {
    return Error{ErrorCode::kTruncatedFile,
                 "an artifact of " + std::to_string(sealed.size()) + " bytes is too short", "", ""};
  }
  if (std::memcmp(sealed.data(), kMagic.data(), kMagic.size()) != 0) {
    return Error{ErrorCode::kBadMagic, "not a sightline artifact", "", "byte 0"};
  }
  const std::span<const std::byte> body = sealed.first(sealed.size() - kChecksumSize);
  std::uint64_t checksum = 0;
  std::memcpy(&checksum, sealed.data() + body.size(), kChecksumSize);
  if (checksum != xxh3(body)) {
    return Error{ErrorCode::kChecksumMismatch, "the artifact is damaged or cut short", "",
                 "byte " + std::to_string(body.size())};
  }
  ByteReader reader(body.subspan(kMagic.size()));
  const auto found_version = reader.get<std::uint32_t>();
  std::string found_name;
  reader.get_string(found_name);
  const std::size_t size = reader.get_count(1);
  if (!reader.ok() || size != reader.remaining()) {
    return Error{ErrorCode::kTruncatedFile, "the artifact's envelope is malformed", "",
                 "byte " + std::to_string(reader.offset() + kMagic.size())};
  }
  if (found_name != name) {
    return Error{ErrorCode::kBadLayer,
                 "found a " + found_name + ", expected a " + std::string(name), "", ""};
  }
  if (found_version != version) {
    const bool newer = found_version > version;
    return Error{newer ? ErrorCode::kFutureVersion : ErrorCode::kOldVersion,
                 "a " + found_name + " of version " + std::to_string(found_version) +
                     ", this program reads version " + std::to_string(version),
                 "", ""};
  }
  return body.last(size);
}

}  // namespace sightline
