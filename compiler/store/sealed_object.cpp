#include "compiler/store/sealed_object.h"

#include <algorithm>
#include <cstring>

#include "formats/base/bytes.h"

namespace sightline {
namespace {

constexpr std::string_view kMagic("SLO\x1a", 4);
constexpr std::size_t kTailSize = 32 + 8 + 4 + 32 + 4;  // behind the kind

Error fault(ErrorCode code, const std::string& message) { return {code, message, "", ""}; }

Digest digest_of(std::span<const std::byte> content, std::span<const std::byte> seal) {
  Sha256Stream stream;
  stream.add(content);
  stream.add(seal);
  return stream.finish();
}

Digest get_digest(ByteReader& reader) {
  Digest digest{};
  for (std::uint8_t& byte : digest) reader.get(byte);
  return digest;
}

}  // namespace

std::vector<std::byte> seal_of(const ObjectName& name, std::span<const std::byte> content) {
  ByteWriter writer;
  writer.append(name.kind.data(), name.kind.size());
  writer.append(name.key.data(), name.key.size());
  writer.put<std::uint64_t>(content.size());
  writer.put<std::uint32_t>(static_cast<std::uint32_t>(name.kind.size()));
  const Digest digest = digest_of(content, writer.bytes());
  writer.append(digest.data(), digest.size());
  writer.append(kMagic.data(), kMagic.size());
  return writer.take();
}

Result<SealedObject> open_object(std::span<const std::byte> sealed) {
  const bool is_sealed =
      sealed.size() >= kTailSize &&
      std::memcmp(sealed.last(kMagic.size()).data(), kMagic.data(), kMagic.size()) == 0;
  if (!is_sealed) return fault(ErrorCode::kBadMagic, "no sealed object, or cut short");
  ByteReader reader(sealed.last(kTailSize));
  const auto key = get_digest(reader);
  const auto content_size = reader.get<std::uint64_t>();
  const auto kind_size = reader.get<std::uint32_t>();
  const auto digest = get_digest(reader);
  const std::size_t before_tail = sealed.size() - kTailSize;
  if (content_size > before_tail || before_tail - content_size != kind_size) {
    return fault(ErrorCode::kOutOfBounds, "its lengths are not those of the file");
  }
  const std::span<const std::byte> content = sealed.first(content_size);
  const std::size_t digested = sealed.size() - digest.size() - kMagic.size();
  if (digest_of(content, sealed.first(digested).subspan(content_size)) != digest) {
    return fault(ErrorCode::kDigestMismatch, "damaged: found another SHA-256 than its own");
  }
  const std::span<const std::byte> kind = sealed.subspan(content_size, kind_size);
  SealedObject object{{std::string(kind_size, '\0'), key}, content};
  std::transform(kind.begin(), kind.end(), object.name.kind.begin(),
                 [](std::byte byte) { return static_cast<char>(byte); });
  return object;
}

}  // namespace sightline
