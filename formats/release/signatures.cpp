#include "formats/release/signatures.h"

#include <sodium.h>

#include <algorithm>
#include <optional>

#include "formats/base/check.h"
#include "formats/release/base64.h"

namespace sightline {
namespace {

constexpr std::string_view kUntrusted = "untrusted comment: ";
constexpr std::string_view kTrusted = "trusted comment: ";
constexpr std::size_t kLongestComment = 1024;
constexpr std::size_t kSignatureSize = 2 + 8 + 64;

using Hash = std::array<std::uint8_t, 64>;

const std::uint8_t* bytes_of(std::string_view text) {
  return reinterpret_cast<const std::uint8_t*>(text.data());
}

Hash blake2b(std::string_view message) {
  Hash hash{};
  crypto_generichash(hash.data(), hash.size(), bytes_of(message), message.size(), nullptr, 0);
  return hash;
}

std::string commented(const std::array<std::uint8_t, 64>& signature, std::string_view comment) {
  std::string message(signature.begin(), signature.end());
  return message.append(comment);
}

// minisign's own comments hold tabs.
bool is_printable(std::string_view text) {
  return std::all_of(text.begin(), text.end(),
                     [](char c) { return (c >= ' ' && c <= '~') || c == '\t'; });
}

// Takes line after line and remembers which one was wrong.
class Lines {
 public:
  explicit Lines(std::string_view text) : text_(text) {}
  [[nodiscard]] bool at_end() const { return text_.empty(); }
  // The next line without its prefix; nothing where there is none, or none with this prefix.
  std::optional<std::string_view> take(std::string_view prefix) {
    number_ += 1;
    const std::size_t end = text_.find('\n');
    if (end == std::string_view::npos || !text_.starts_with(prefix)) return {};
    const std::string_view line = text_.substr(prefix.size(), end - prefix.size());
    text_.remove_prefix(end + 1);
    if (line.size() > kLongestComment || !is_printable(line)) return {};
    return line;
  }
  [[nodiscard]] Error wrong(std::string_view expected) const {
    return {ErrorCode::kMalformedSignature, "expected " + std::string(expected), "",
            concat("line ", number_)};
  }

 private:
  std::string_view text_;
  std::size_t number_ = 0;
};

Result<Signature> parse_one(Lines& lines) {
  Signature signature;
  if (!lines.take(kUntrusted)) return lines.wrong("an untrusted comment");
  const std::optional<std::string_view> first = lines.take("");
  const auto bytes = first ? bytes_of_base64(*first, kSignatureSize) : std::nullopt;
  if (!bytes || (*bytes)[0] != 'E' || (*bytes)[1] != 'D') {
    return lines.wrong("a prehashed Ed25519 signature of 74 bytes");
  }
  std::copy_n(bytes->begin() + 2, 8, signature.key_id.begin());
  std::copy_n(bytes->begin() + 10, 64, signature.of_message.begin());
  const std::optional<std::string_view> comment = lines.take(kTrusted);
  if (!comment) return lines.wrong("a trusted comment");
  signature.trusted_comment = *comment;
  const std::optional<std::string_view> last = lines.take("");
  const auto of_comment = last ? bytes_of_base64(*last, 64) : std::nullopt;
  if (!of_comment) return lines.wrong("a signature of 64 bytes");
  std::copy_n(of_comment->begin(), 64, signature.of_comment.begin());
  return signature;
}

}  // namespace

std::string sign(std::string_view message, const SecretKey& key, std::string_view trusted_comment) {
  SIGHTLINE_CHECK(sodium_init() >= 0);
  SIGHTLINE_CHECK(trusted_comment.size() <= kLongestComment && is_printable(trusted_comment));
  const Hash hash = blake2b(message);
  std::array<std::uint8_t, 64> of_message{};
  crypto_sign_detached(of_message.data(), nullptr, hash.data(), hash.size(), key.bytes.data());
  const std::string rest = commented(of_message, trusted_comment);
  std::array<std::uint8_t, 64> of_comment{};
  crypto_sign_detached(of_comment.data(), nullptr, bytes_of(rest), rest.size(), key.bytes.data());
  std::vector<std::uint8_t> first = {'E', 'D'};
  first.insert(first.end(), key.id.begin(), key.id.end());
  first.insert(first.end(), of_message.begin(), of_message.end());
  return concat(kUntrusted, "signature by ", to_hex(key.id), "\n", base64_of(first), "\n", kTrusted,
                trusted_comment, "\n", base64_of(of_comment), "\n");
}

Result<std::vector<Signature>> parse_signatures(std::string_view text) {
  if (text.size() > kLargestSignatureFile) {
    return Error{ErrorCode::kMalformedSignature,
                 concat(text.size(), " bytes are too many for signatures")};
  }
  Lines lines(text);
  std::vector<Signature> signatures;
  do {
    SIGHTLINE_ASSIGN(Signature signature, parse_one(lines));
    signatures.push_back(std::move(signature));
    if (signatures.size() > kMostSignatures) return lines.wrong("at most 16 signatures");
  } while (!lines.at_end());
  return signatures;
}

bool is_valid(const Signature& signature, std::string_view message, const PublicKey& key) {
  if (sodium_init() < 0) return false;
  const Hash hash = blake2b(message);
  const std::string rest = commented(signature.of_message, signature.trusted_comment);
  return signature.key_id == key.id &&
         crypto_sign_verify_detached(signature.of_message.data(), hash.data(), hash.size(),
                                     key.point.data()) == 0 &&
         crypto_sign_verify_detached(signature.of_comment.data(), bytes_of(rest), rest.size(),
                                     key.point.data()) == 0;
}

}  // namespace sightline
