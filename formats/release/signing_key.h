#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "formats/base/result.h"

// Ed25519 keys in the files of minisign, so that keys made by either program serve the other
// (schemas/release_format.md).

namespace sightline {

using KeyId = std::array<std::uint8_t, 8>;  // a name drawn at random, no proof of anything

struct PublicKey {
  KeyId id{};
  std::array<std::uint8_t, 32> point{};
  friend bool operator==(const PublicKey&, const PublicKey&) = default;
};

// Wiped from memory when it goes.
struct SecretKey {
  KeyId id{};
  std::array<std::uint8_t, 64> bytes{};  // seed, then public point

  SecretKey() = default;
  SecretKey(const SecretKey&) = default;
  SecretKey& operator=(const SecretKey&) = default;
  ~SecretKey();
};

// From the operating system's random numbers.
SecretKey new_secret_key();
// The same key for the same seed: for tests and fuzzers, which must repeat.
SecretKey secret_key_from_seed(const std::array<std::uint8_t, 32>& seed);
PublicKey public_key_of(const SecretKey& secret);

// Whether the point is one that a secret key can have: on the curve, in the large group, written in
// the one way. With a point of small order anybody can sign anything.
bool is_sound(const PublicKey& key);

// 56 characters: what a root record and `minisign -P` call a key.
std::string to_base64(const PublicKey& key);
// Error: malformed-signature.
Result<PublicKey> public_key_from_base64(std::string_view text);

// Files of two lines each. With a passphrase the secret is encrypted (scrypt); without, who reads
// the file has the key.
std::string encode_public_key_file(const PublicKey& key);
Result<PublicKey> decode_public_key_file(std::string_view text);
std::string encode_secret_key_file(const SecretKey& key,
                                   const std::optional<std::string>& passphrase);
// Errors: malformed-signature; wrong-key where the passphrase is wrong or missing.
Result<SecretKey> decode_secret_key_file(std::string_view text,
                                         const std::optional<std::string>& passphrase);

// "BF4DFB9E71E0068C", as minisign prints it.
std::string to_hex(const KeyId& id);

}  // namespace sightline
