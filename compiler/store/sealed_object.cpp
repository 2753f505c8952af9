#include "compiler/store/sealed_object.h"

#include <cstring>
#include <span>
#include <vector>

#include "formats/base/bytes.h"

namespace sightline {
namespace {

constexpr std::string_view kMagic("SLO\x1a", 4);
constexpr std::size_t kTailSize = 32 + 8 + 4 + 32 + 4;  // behind the kind

Error fault(ErrorCode code, const std::string& message) { return {code, message}; }

bool is_magic(std::span<const std::byte> bytes) {
  return std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) == 0;
}

Digest get_digest(ByteReader& reader) {
  Digest digest{};
  for (std::uint8_t& byte : digest) reader.get(byte);
  return digest;
}

}  // namespace

Result<void> write_sealed(const ObjectName& name, const WriteInto& content, const ByteSink& sink) {
  Sha256Stream digest;
  std::uint64_t size = 0;
  SIGHTLINE_TRY(content([&](std::span<const std::byte> piece) -> Result<void> {
    digest.add(piece);
    size += piece.size();
    return sink(piece);
  }));
  ByteWriter seal;
  seal.append(name.kind.data(), name.kind.size());
  seal.append(name.key.data(), name.key.size());
  seal.put(size);
  seal.put<std::uint32_t>(static_cast<std::uint32_t>(name.kind.size()));
  digest.add(seal.bytes());
  const Digest all = digest.finish();
  seal.append(all.data(), all.size());
  seal.append(kMagic.data(), kMagic.size());
  return sink(seal.bytes());
}

Result<SealedObject> open_object(const StoredBytes& sealed) {
  const Error none = fault(ErrorCode::kBadMagic, "no sealed object, or cut short");
  if (sealed.size() < kTailSize) return none;
  const std::uint64_t before_tail = sealed.size() - kTailSize;
  SIGHTLINE_ASSIGN(const std::vector<std::byte> tail, sealed.read(before_tail, kTailSize));
  if (!is_magic(std::span(tail).last(kMagic.size()))) return none;
  ByteReader reader(tail);
  const auto key = get_digest(reader);
  const auto content_size = reader.get<std::uint64_t>();
  const auto kind_size = reader.get<std::uint32_t>();
  const auto digest = get_digest(reader);
  if (content_size > before_tail || before_tail - content_size != kind_size) {
    return fault(ErrorCode::kOutOfBounds, "its lengths are not those of the file");
  }
  Sha256Stream found;
  const StoredBytes digested = sealed.part(0, sealed.size() - digest.size() - kMagic.size());
  SIGHTLINE_TRY(digested.visit([&](std::span<const std::byte> piece) -> Result<void> {
    found.add(piece);
    return {};
  }));
  if (found.finish() != digest) {
    return fault(ErrorCode::kDigestMismatch, "damaged: found another SHA-256 than its own");
  }
  SealedObject object{{std::string(kind_size, '\0'), key}, sealed.part(0, content_size)};
  SIGHTLINE_TRY(sealed.read(content_size, std::as_writable_bytes(std::span(object.name.kind))));
  return object;
}

}  // namespace sightline
