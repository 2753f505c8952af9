// Records and signatures from a server: refused, or read as what they say and nothing else.
// The first byte of an input decides what the rest is.

#include <algorithm>

#include "formats/base/check.h"
#include "formats/release/admission.h"
#include "formats/release/signatures.h"
#include "tests/formats/release/signed_records.h"
#include "tests/fuzz/fuzz.h"

namespace sightline {
namespace {

// Two of three, as a vehicle knows them.
const RootRecord& trusted() {
  static const RootRecord root = root_of({1, 2, 3}, 2, 4);
  return root;
}

void try_release(const std::string& text) {
  const Result<ReleaseRecord> plain = decode_release_record(text);
  if (plain) SIGHTLINE_CHECK(encode(*plain) == text);
  VehicleFacts vehicle;
  vehicle.now_s = 1'900'000'000;
  const Result<ReleaseRecord> admitted =
      admit_release(text, signed_by(text, {1, 2}), trusted(), vehicle);
  if (!admitted) return;
  SIGHTLINE_CHECK(plain.has_value() && *plain == *admitted);
  SIGHTLINE_CHECK(admitted->fleet == trusted().fleet && admitted->expires_s > vehicle.now_s);
  SIGHTLINE_CHECK(admitted->map.name.find('/') == std::string::npos);
  SIGHTLINE_CHECK(!admit_release(text, signed_by(text, {1}), trusted(), vehicle));
  vehicle.seen.release = text;
  SIGHTLINE_CHECK(admit_release(text, signed_by(text, {2, 3}), trusted(), vehicle).has_value());
}

void try_root(const std::string& text) {
  const Result<RootRecord> plain = decode_root_record(text);
  if (plain) SIGHTLINE_CHECK(encode(*plain) == text);
  const Result<RootRecord> next = next_root(trusted(), text, signed_by(text, {1, 2, 3, 4, 5}));
  if (next) SIGHTLINE_CHECK(next->version == trusted().version + 1);
}

// Signatures of a fixed record: nothing that a fuzzer writes is by two keys of the root unless it
// still holds the two signatures of the corpus.
void try_signatures(const std::string& text) {
  const std::string message = "sightline-release 1\n";
  const Result<void> checked = check_signatures(message, text, trusted());
  const Result<std::vector<Signature>> parsed = parse_signatures(text);
  SIGHTLINE_CHECK(!checked || parsed.has_value());
  if (!checked) return;
  std::size_t valid = 0;
  for (const PublicKey& key : trusted().keys) {
    valid +=
        std::any_of(parsed->begin(), parsed->end(),
                    [&](const Signature& signature) { return is_valid(signature, message, key); })
            ? 1U
            : 0U;
  }
  SIGHTLINE_CHECK(valid >= trusted().threshold);
}

void try_keys(const std::string& text) {
  const Result<PublicKey> shared = decode_public_key_file(text);
  if (shared) SIGHTLINE_CHECK(public_key_from_base64(to_base64(*shared)).has_value());
  (void)decode_secret_key_file(text, {});  // without a passphrase: scrypt takes a second
}

}  // namespace
}  // namespace sightline

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sightline;
  if (size == 0) return 0;
  const std::string text(reinterpret_cast<const char*>(data) + 1, size - 1);
  if (data[0] == 'r') try_release(text);
  if (data[0] == 'o') try_root(text);
  if (data[0] == 's') try_signatures(text);
  if (data[0] == 'k') try_keys(text);
  return 0;
}
