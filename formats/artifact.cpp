#include "formats/artifact.h"

#include <array>

#include "formats/base/hash.h"

namespace sightline {
namespace {

constexpr std::array<char, 4> kMagic = {'S', 'L', 'A', '\x1a'};

}  // namespace

std::vector<std::byte> seal(std::string_view name, std::uint32_t version,
                            std::vector<std::byte> payload) {
  ByteWriter writer;
  writer.append(kMagic.data(), kMagic.size());
  writer.put(version);
  writer.put_string(name);
  writer.put_array(std::span<const std::byte>(payload));
  const std::uint64_t checksum = xxh3(writer.bytes());
  writer.put(checksum);
  return writer.take();
}

Result<std::vector<std::byte>> unseal(std::span<const std::byte> sealed, std::string_view name,
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
  std::vector<std::byte> payload;
  reader.get_array(payload);
  if (!reader.at_end()) {
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
  return payload;
}

}  // namespace sightline
