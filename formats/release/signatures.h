#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/result.h"
#include "formats/release/signing_key.h"

// Signatures beside a record, in the form of `minisign` (prehashed, "ED"): a file of four lines for
// each signer, one after another, so that a stock `minisign -V` verifies the first
// (schemas/release_format.md).

namespace sightline {

inline constexpr std::size_t kMostSignatures = 16;
inline constexpr std::size_t kLargestSignatureFile = 32768;

struct Signature {
  KeyId key_id{};
  std::array<std::uint8_t, 64> of_message{};  // of its BLAKE2b-512
  std::string trusted_comment;
  std::array<std::uint8_t, 64> of_comment{};  // of the first signature and the trusted comment
};

// Four lines. The comment is printable ASCII or tabs.
std::string sign(std::string_view message, const SecretKey& key, std::string_view trusted_comment);

// Between 1 and kMostSignatures. Error: malformed-signature, naming the line.
Result<std::vector<Signature>> parse_signatures(std::string_view text);

// Message and trusted comment are what the owner of the key signed.
bool is_valid(const Signature& signature, std::string_view message, const PublicKey& key);

}  // namespace sightline
