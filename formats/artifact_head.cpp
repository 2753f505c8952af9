#include "formats/artifact_head.h"

#include <cstring>
#include <string>

#include "formats/base/bytes.h"

namespace sightline {
namespace {

constexpr std::array<char, 4> kMagic = {'S', 'L', 'A', '\x1a'};

}  // namespace

std::vector<std::byte> head_of(std::string_view name, std::uint32_t version, std::uint64_t size) {
  ByteWriter head;
  head.append(kMagic.data(), kMagic.size());
  head.put(version);
  head.put_string(name);
  head.put(size);
  return head.take();
}

bool has_magic(std::span<const std::byte> bytes) {
  return bytes.size() >= kMagic.size() &&
         std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) == 0;
}

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
                 "byte " + std::to_string(head_size)};
  }
  if (found_name != name) {
    return Error{ErrorCode::kBadLayer,
                 "found a " + found_name + ", expected a " + std::string(name)};
  }
  if (found_version != version) {
    const bool newer = found_version > version;
    return Error{newer ? ErrorCode::kFutureVersion : ErrorCode::kOldVersion,
                 "a " + found_name + " of version " + std::to_string(found_version) +
                     ", this program reads version " + std::to_string(version)};
  }
  return head_size;
}

Error too_short_to_be_sealed(std::uint64_t size) {
  return {ErrorCode::kTruncatedFile,
          "an artifact of " + std::to_string(size) + " bytes is too short"};
}

Error not_sealed() { return {ErrorCode::kBadMagic, "not a sightline artifact", "", "byte 0"}; }

Error damaged_artifact(std::uint64_t body_size) {
  return {ErrorCode::kChecksumMismatch, "the artifact is damaged or cut short", "",
          "byte " + std::to_string(body_size)};
}

}  // namespace sightline
