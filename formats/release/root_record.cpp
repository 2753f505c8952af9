#include "formats/release/root_record.h"

#include "formats/release/record_text.h"

namespace sightline {
namespace {

Error malformed(const std::string& message) { return {ErrorCode::kMalformedRecord, message}; }

// One signer under two names would count twice.
Result<void> check_keys(const std::vector<PublicKey>& keys) {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (!is_sound(keys[i])) {
      return malformed("key " + to_hex(keys[i].id) +
                       " is no sound point: anybody could sign by it");
    }
    for (std::size_t k = 0; k < i; ++k) {
      if (keys[i].id == keys[k].id || keys[i].point == keys[k].point) {
        return malformed("key " + to_hex(keys[i].id) + " is there twice");
      }
    }
    if (i > 0 && to_base64(keys[i - 1]) > to_base64(keys[i])) {
      return malformed("keys must ascend by their text");
    }
  }
  return {};
}

}  // namespace

Result<void> validate(const RootRecord& record) {
  if (!is_record_name(record.fleet)) return malformed("the fleet needs a name");
  if (record.version == 0) return malformed("versions start at 1");
  if (utc_seconds(utc_text(record.expires_s)) != record.expires_s) {
    return malformed("the expiry must lie between 1970 and 9999");
  }
  if (record.keys.empty() || record.keys.size() > kMostKeys) {
    return malformed("found " + std::to_string(record.keys.size()) + " keys, expected 1 to 16");
  }
  if (record.threshold == 0 || record.threshold > record.keys.size()) {
    return malformed("the threshold is " + std::to_string(record.threshold) + " of " +
                     std::to_string(record.keys.size()) + " keys");
  }
  return check_keys(record.keys);
}

std::string encode(const RootRecord& record) {
  std::string text = "sightline-root 1\n";
  text += "fleet " + record.fleet + "\n";
  text += "version " + std::to_string(record.version) + "\n";
  text += "expires " + utc_text(record.expires_s) + "\n";
  text += "threshold " + std::to_string(record.threshold) + "\n";
  for (const PublicKey& key : record.keys) text += "key " + to_base64(key) + "\n";
  return text;
}

Result<RootRecord> decode_root_record(std::string_view text) {
  RecordReader reader(text);
  RootRecord record;
  if (reader.take("sightline-root") != "1") reader.fail("expected \"sightline-root 1\"");
  record.fleet = reader.take_name("fleet");
  record.version = reader.take_number("version");
  record.expires_s = reader.take_time("expires");
  const std::uint64_t threshold = reader.take_number("threshold");
  if (threshold > kMostKeys) reader.fail("a threshold beyond 16");
  record.threshold = static_cast<std::uint32_t>(threshold);
  while (reader.next_is("key")) {
    const Result<PublicKey> key = public_key_from_base64(reader.take("key"));
    if (!key) reader.fail(key.error().message);
    if (key) record.keys.push_back(*key);
    if (record.keys.size() > kMostKeys) reader.fail("more than 16 keys");
  }
  SIGHTLINE_TRY(reader.finish());
  SIGHTLINE_TRY(validate(record));
  return record;
}

}  // namespace sightline
