#include "formats/release/signatures.h"

#include <gtest/gtest.h>

#include "tests/formats/release/signed_records.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

TEST(Signatures, AreValidForTheirMessageAndKeyAlone) {
  const std::string text = sign("message", key_of(1), "who and why");
  const std::vector<Signature> parsed = value_of(parse_signatures(text));
  const Signature& signature = parsed.front();
  EXPECT_EQ(signature.trusted_comment, "who and why");
  EXPECT_TRUE(is_valid(signature, "message", public_key_of(key_of(1))));
  EXPECT_FALSE(is_valid(signature, "messagf", public_key_of(key_of(1))));
  EXPECT_FALSE(is_valid(signature, "message", public_key_of(key_of(2))));
  PublicKey renamed = public_key_of(key_of(2));
  renamed.id = signature.key_id;  // an id proves nothing
  EXPECT_FALSE(is_valid(signature, "message", renamed));
}

TEST(Signatures, WithOneBitFlippedOutsideTheUntrustedCommentAreWorthNothing) {
  const std::string text = sign("message", key_of(1), "comment");
  const std::size_t begin = text.find('\n');
  for (std::size_t i = begin; i < text.size(); ++i) {
    std::string damaged = text;
    damaged[i] = static_cast<char>(damaged[i] ^ (1 << (i % 7)));
    const Result<std::vector<Signature>> parsed = parse_signatures(damaged);
    EXPECT_FALSE(parsed && is_valid(parsed->front(), "message", public_key_of(key_of(1)))) << i;
  }
  for (std::size_t size = 0; size < text.size(); ++size) {
    EXPECT_FALSE(parse_signatures(std::string_view(text).substr(0, size))) << size;
  }
}

TEST(Signatures, OfTheLegacyFormOrTooManyAreRefused) {
  const std::string text = sign("message", key_of(1), "comment");
  std::string many;
  for (std::size_t i = 0; i < kMostSignatures; ++i) many += text;
  EXPECT_TRUE(parse_signatures(many));
  EXPECT_FALSE(parse_signatures(many + text));
  std::string legacy = text;
  legacy.replace(legacy.find('\n') + 1, 3, "RWQ");  // "Ed" in base64
  EXPECT_FALSE(parse_signatures(legacy));
}

TEST(KeyFiles, ReadBackAndAreRefusedWhenDamaged) {
  const SecretKey key = key_of(3);
  const std::string secret = encode_secret_key_file(key, {});
  EXPECT_EQ(value_of(decode_secret_key_file(secret, {})).bytes, key.bytes);
  for (std::size_t i = secret.find('\n'); i < secret.size(); ++i) {
    std::string damaged = secret;
    damaged[i] = static_cast<char>(damaged[i] ^ 1);
    const Result<SecretKey> read = decode_secret_key_file(damaged, {});
    // What is neither key nor checksum (salt and cost of no passphrase) may change.
    EXPECT_TRUE(!read || read->bytes == key.bytes) << i;
  }
  const PublicKey shared = public_key_of(key);
  EXPECT_EQ(value_of(decode_public_key_file(encode_public_key_file(shared))), shared);
}

TEST(KeyFiles, WithAPassphraseOpenWithThatOneAlone) {
  const SecretKey key = new_secret_key();
  const std::string secret = encode_secret_key_file(key, "open sesame");
  EXPECT_EQ(decode_secret_key_file(secret, {}).error().code, ErrorCode::kWrongKey);
  EXPECT_EQ(decode_secret_key_file(secret, "open barley").error().code, ErrorCode::kWrongKey);
  const SecretKey back = value_of(decode_secret_key_file(secret, "open sesame"));
  EXPECT_EQ(back.bytes, key.bytes);
  EXPECT_EQ(back.id, key.id);
}

}  // namespace
}  // namespace sightline
