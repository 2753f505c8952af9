#include "formats/base/hash.h"

#include <openssl/evp.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "formats/base/check.h"

namespace sightline {
namespace {

EVP_MD_CTX* context(void* state) { return static_cast<EVP_MD_CTX*>(state); }
XXH3_state_t* xxh3_state(void* state) { return static_cast<XXH3_state_t*>(state); }

}  // namespace

Sha256Stream::Sha256Stream() : state_(EVP_MD_CTX_new()) {
  SIGHTLINE_CHECK(state_ != nullptr);
  SIGHTLINE_CHECK(EVP_DigestInit_ex(context(state_), EVP_sha256(), nullptr) == 1);
}

Sha256Stream::~Sha256Stream() { EVP_MD_CTX_free(context(state_)); }

void Sha256Stream::add(std::span<const std::byte> bytes) {
  SIGHTLINE_CHECK(EVP_DigestUpdate(context(state_), bytes.data(), bytes.size()) == 1);
}

Digest Sha256Stream::finish() {
  Digest digest{};
  SIGHTLINE_CHECK(EVP_DigestFinal_ex(context(state_), digest.data(), nullptr) == 1);
  return digest;
}

void DigestBuilder::add(std::span<const std::byte> part) {
  const std::uint64_t size = part.size();
  stream_.add(std::as_bytes(std::span(&size, 1)));
  stream_.add(part);
}

void DigestBuilder::add(std::string_view part) {
  add(std::as_bytes(std::span(part.data(), part.size())));
}

void DigestBuilder::add(const Digest& part) { add(std::as_bytes(std::span(part))); }

Digest sha256(std::span<const std::byte> bytes) {
  Sha256Stream stream;
  stream.add(bytes);
  return stream.finish();
}

Digest sha256(std::string_view text) {
  return sha256(std::as_bytes(std::span(text.data(), text.size())));
}

std::string to_hex(const Digest& digest) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  text.reserve(2 * digest.size());
  for (const std::uint8_t byte : digest) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

std::uint64_t xxh3(std::span<const std::byte> bytes) {
  return XXH3_64bits(bytes.data(), bytes.size());
}

Xxh3Stream::Xxh3Stream() : state_(XXH3_createState()) {
  SIGHTLINE_CHECK(state_ != nullptr);
  SIGHTLINE_CHECK(XXH3_64bits_reset(xxh3_state(state_)) == XXH_OK);
}

Xxh3Stream::~Xxh3Stream() { XXH3_freeState(xxh3_state(state_)); }

void Xxh3Stream::add(std::span<const std::byte> bytes) {
  SIGHTLINE_CHECK(XXH3_64bits_update(xxh3_state(state_), bytes.data(), bytes.size()) == XXH_OK);
}

std::uint64_t Xxh3Stream::finish() const { return XXH3_64bits_digest(xxh3_state(state_)); }

Digest derived_digest(std::string_view kind, const Digest& source,
                      std::span<const std::byte> values) {
  DigestBuilder builder;
  builder.add(kind);
  builder.add(source);
  builder.add(values);
  return builder.finish();
}

}  // namespace sightline
