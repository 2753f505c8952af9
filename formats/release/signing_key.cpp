#include "formats/release/signing_key.h"

#include <sodium.h>

#include <algorithm>
#include <vector>

#include "formats/base/bytes.h"
#include "formats/base/check.h"
#include "formats/release/base64.h"

namespace sightline {
namespace {

constexpr std::string_view kComment = "untrusted comment: ";
constexpr std::size_t kPublicSize = 2 + 8 + 32;

// A secret key file: algorithms, salt, cost, then id, secret and checksum, which a passphrase
// hides.
constexpr std::size_t kSaltSize = 32;
constexpr std::size_t kHiddenSize = 8 + 64 + 32;
constexpr std::size_t kHiddenBegin = 6 + kSaltSize + 8 + 8;
constexpr std::size_t kSecretSize = kHiddenBegin + kHiddenSize;
constexpr std::array<std::uint8_t, 6> kPlain = {'E', 'd', 0, 0, 'B', '2'};
constexpr std::array<std::uint8_t, 6> kScrypt = {'E', 'd', 'S', 'c', 'B', '2'};
// What scrypt is to cost here: a quarter of a second and 64 MiB.
constexpr std::uint64_t kOperations = std::uint64_t{1} << 22;
constexpr std::uint64_t kMemory = std::uint64_t{1} << 26;
// A file asks for memory and time; more than minisign itself asks for (1 GiB) is no key of ours.
constexpr std::uint64_t kMostMemory = std::uint64_t{1} << 30;

// Using libsodium before this would draw from an unseeded generator.
void start_sodium() { SIGHTLINE_CHECK(sodium_init() >= 0); }

Error malformed(const std::string& message) { return {ErrorCode::kMalformedSignature, message}; }

// The second of two lines; the first is a comment that nothing vouches for.
Result<std::string_view> second_line(std::string_view text) {
  const std::size_t end = text.find('\n');
  if (!text.starts_with(kComment) || end == std::string_view::npos) {
    return malformed(concat("a key file starts with \"", kComment, "\""));
  }
  std::string_view line = text.substr(end + 1);
  if (line.ends_with('\n')) line.remove_suffix(1);
  return line;
}

using Checksum = std::array<std::uint8_t, 32>;

Checksum checksum_of(const SecretKey& key) {
  std::vector<std::uint8_t> message = {'E', 'd'};
  message.insert(message.end(), key.id.begin(), key.id.end());
  message.insert(message.end(), key.bytes.begin(), key.bytes.end());
  Checksum checksum{};
  crypto_generichash(checksum.data(), checksum.size(), message.data(), message.size(), nullptr, 0);
  sodium_memzero(message.data(), message.size());
  return checksum;
}

// minisign writes no checksum where there is no passphrase to be wrong; then the public half must
// be that of the secret half.
bool fits_together(const SecretKey& key) {
  SecretKey again;
  std::array<std::uint8_t, 32> point{};
  crypto_sign_seed_keypair(point.data(), again.bytes.data(), key.bytes.data());
  return again.bytes == key.bytes;
}

// Exclusive or with a stream made from the passphrase: hides and shows alike.
bool mask(std::span<std::uint8_t> hidden, const std::string& passphrase,
          std::span<const std::uint8_t> salt, std::uint64_t operations, std::uint64_t memory) {
  std::array<std::uint8_t, kHiddenSize> stream{};
  if (crypto_pwhash_scryptsalsa208sha256(stream.data(), stream.size(), passphrase.data(),
                                         passphrase.size(), salt.data(), operations,
                                         static_cast<std::size_t>(memory)) != 0) {
    return false;
  }
  for (std::size_t i = 0; i < hidden.size(); ++i) hidden[i] ^= stream[i];
  sodium_memzero(stream.data(), stream.size());
  return true;
}

Result<void> show(std::span<std::uint8_t> file, const std::optional<std::string>& passphrase) {
  if (std::equal(kPlain.begin(), kPlain.end(), file.begin())) return {};
  if (!std::equal(kScrypt.begin(), kScrypt.end(), file.begin())) {
    return malformed("the secret key is of an unknown kind");
  }
  if (!passphrase)
    return Error{ErrorCode::kWrongKey, "the secret key is encrypted; give its passphrase"};
  ByteReader cost(std::as_bytes(file.subspan(6 + kSaltSize)));
  const auto operations = cost.get<std::uint64_t>();
  const auto memory = cost.get<std::uint64_t>();
  if (memory > kMostMemory || operations > kMostMemory) {
    return malformed("the secret key requires more memory or time than is allowed");
  }
  if (!mask(file.subspan(kHiddenBegin), *passphrase, file.subspan(6, kSaltSize), operations,
            memory)) {
    return Error{ErrorCode::kOutOfMemory, "the passphrase cannot be hashed"};
  }
  return {};
}

}  // namespace

SecretKey::~SecretKey() { sodium_memzero(bytes.data(), bytes.size()); }

SecretKey new_secret_key() {
  start_sodium();
  SecretKey key;
  std::array<std::uint8_t, 32> point{};
  crypto_sign_keypair(point.data(), key.bytes.data());
  randombytes_buf(key.id.data(), key.id.size());
  return key;
}

SecretKey secret_key_from_seed(const std::array<std::uint8_t, 32>& seed) {
  start_sodium();
  SecretKey key;
  std::array<std::uint8_t, 32> point{};
  crypto_sign_seed_keypair(point.data(), key.bytes.data(), seed.data());
  std::copy_n(point.begin(), key.id.size(), key.id.begin());
  return key;
}

PublicKey public_key_of(const SecretKey& secret) {
  PublicKey key;
  key.id = secret.id;
  std::copy_n(secret.bytes.begin() + 32, key.point.size(), key.point.begin());
  return key;
}

bool is_sound(const PublicKey& key) {
  start_sodium();
  return crypto_core_ed25519_is_valid_point(key.point.data()) == 1;
}

std::string to_base64(const PublicKey& key) {
  std::vector<std::uint8_t> bytes = {'E', 'd'};
  bytes.insert(bytes.end(), key.id.begin(), key.id.end());
  bytes.insert(bytes.end(), key.point.begin(), key.point.end());
  return base64_of(bytes);
}

Result<PublicKey> public_key_from_base64(std::string_view text) {
  const auto bytes = bytes_of_base64(text, kPublicSize);
  if (!bytes || (*bytes)[0] != 'E' || (*bytes)[1] != 'd') {
    return malformed(
        concat("found \"", text.substr(0, 60), "\", expected a public key of 56 characters"));
  }
  PublicKey key;
  std::copy_n(bytes->begin() + 2, key.id.size(), key.id.begin());
  std::copy_n(bytes->begin() + 10, key.point.size(), key.point.begin());
  return key;
}

std::string encode_public_key_file(const PublicKey& key) {
  return concat(kComment, "sightline public key ", to_hex(key.id), "\n", to_base64(key), "\n");
}

Result<PublicKey> decode_public_key_file(std::string_view text) {
  SIGHTLINE_ASSIGN(const std::string_view line, second_line(text));
  return public_key_from_base64(line);
}

std::string encode_secret_key_file(const SecretKey& key,
                                   const std::optional<std::string>& passphrase) {
  start_sodium();
  const auto& kind = passphrase ? kScrypt : kPlain;
  std::vector<std::uint8_t> file(kind.begin(), kind.end());
  file.resize(kHiddenBegin);
  const std::uint64_t cost[] = {kOperations, kMemory};
  if (passphrase) {
    randombytes_buf(file.data() + 6, kSaltSize);
    std::memcpy(file.data() + 6 + kSaltSize, cost, sizeof cost);
  }
  file.insert(file.end(), key.id.begin(), key.id.end());
  file.insert(file.end(), key.bytes.begin(), key.bytes.end());
  const Checksum checksum = checksum_of(key);
  file.insert(file.end(), checksum.begin(), checksum.end());
  const std::span<std::uint8_t> bytes(file);
  if (passphrase) {
    SIGHTLINE_CHECK(mask(bytes.subspan(kHiddenBegin), *passphrase, bytes.subspan(6, kSaltSize),
                         cost[0], cost[1]));
  }
  std::string text = concat(kComment, "minisign encrypted secret key\n", base64_of(file));
  sodium_memzero(file.data(), file.size());
  return text + "\n";
}

Result<SecretKey> decode_secret_key_file(std::string_view text,
                                         const std::optional<std::string>& passphrase) {
  start_sodium();
  SIGHTLINE_ASSIGN(const std::string_view line, second_line(text));
  auto file = bytes_of_base64(line, kSecretSize);
  if (!file) return malformed("the file is not a secret key");
  SIGHTLINE_TRY(show(*file, passphrase));
  SecretKey key;
  const auto hidden = file->begin() + kHiddenBegin;
  std::copy_n(hidden, key.id.size(), key.id.begin());
  std::copy_n(hidden + 8, key.bytes.size(), key.bytes.begin());
  const Checksum checksum = checksum_of(key);
  const bool has_checksum = passphrase || std::any_of(hidden + 8 + 64, file->end(),
                                                      [](std::uint8_t byte) { return byte != 0; });
  const bool is_right =
      fits_together(key) &&
      (!has_checksum || std::equal(checksum.begin(), checksum.end(), hidden + 8 + 64));
  sodium_memzero(file->data(), file->size());
  if (!is_right) {
    return Error{ErrorCode::kWrongKey, "the passphrase is wrong, or the secret key is damaged"};
  }
  return key;
}

std::string to_hex(const KeyId& id) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  std::string text;
  // Printed as a number, which lies little-endian in the file.
  for (auto byte = id.rbegin(); byte != id.rend(); ++byte) {
    text += kDigits[*byte >> 4];
    text += kDigits[*byte & 15];
  }
  return text;
}

}  // namespace sightline
