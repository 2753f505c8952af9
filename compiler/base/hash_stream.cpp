#include "compiler/base/hash_stream.h"

#include <openssl/evp.h>

#include "compiler/base/check.h"

namespace sightline {
namespace {

EVP_MD_CTX* context(void* state) { return static_cast<EVP_MD_CTX*>(state); }

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

}  // namespace sightline
