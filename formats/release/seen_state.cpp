#include "formats/release/seen_state.h"

#include <algorithm>

#include "formats/release/release_record.h"

namespace sightline {
namespace {

constexpr std::string_view kReleaseBegins = "sightline-release ";

bool is_before(const PublicKey& a, const PublicKey& b) { return to_base64(a) < to_base64(b); }

bool ascends(const std::vector<PublicKey>& keys) {
  return std::adjacent_find(keys.begin(), keys.end(), [](const PublicKey& a, const PublicKey& b) {
           return !is_before(a, b);
         }) == keys.end();
}

}  // namespace

std::string encode(const SeenState& state) {
  std::string text = "sightline-seen 1\ntime " + utc_text(state.time_s) + "\n";
  for (const PublicKey& key : state.keys) text += "key " + to_base64(key) + "\n";
  return text + state.release;
}

Result<SeenState> decode_seen_state(std::string_view text) {
  SeenState state;
  const std::size_t begin = text.find(kReleaseBegins);
  state.release = begin == std::string_view::npos ? "" : text.substr(begin);
  RecordReader reader(text.substr(0, begin));
  if (begin != 0) {
    if (reader.take("sightline-seen") != "1") reader.fail("expected \"sightline-seen 1\"");
    state.time_s = reader.take_time("time");
    while (reader.next_is("key")) {
      const Result<PublicKey> key = public_key_from_base64(reader.take("key"));
      if (!key) reader.fail(key.error().message);
      if (key) state.keys.push_back(*key);
    }
    if (state.keys.size() > kMostSeenKeys || !ascends(state.keys)) {
      reader.fail("expected at most 512 keys, ascending");
    }
  }
  SIGHTLINE_TRY(reader.finish());
  SIGHTLINE_TRY(decode_release_record(state.release));
  return state;
}

void add_keys(const std::vector<PublicKey>& keys, SeenState& state) {
  for (const PublicKey& key : keys) {
    const auto place = std::lower_bound(state.keys.begin(), state.keys.end(), key, is_before);
    if (place != state.keys.end() && *place == key) continue;
    if (state.keys.size() < kMostSeenKeys) state.keys.insert(place, key);
  }
}

}  // namespace sightline
