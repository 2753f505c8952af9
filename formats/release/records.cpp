#include "formats/release/records.h"

#include <algorithm>
#include <functional>

#include "formats/map/manifest.h"
#include "formats/reader/map_container.h"
#include "formats/reader/mapped_file.h"
#include "formats/release/record_text.h"

namespace sightline {
namespace {

Error malformed(const std::string& message) { return {ErrorCode::kMalformedRecord, message}; }

std::string text_of(const ReleasedFile& file) {
  return concat(file.name, " ", file.size, " ", to_hex(file.sha256));
}

ReleasedFile file_of(RecordReader& reader, const std::vector<std::string_view>& words) {
  ReleasedFile file;
  file.name = reader.file_name(words[0]);
  file.size = reader.number(words[1]);
  file.sha256 = reader.digest(words[2]);
  return file;
}

// The first line.
void take_kind(RecordReader& reader, const std::string& kind) {
  if (reader.take(kind) != "1") reader.fail(concat("expected \"", kind, " 1\""));
}

void take_key(RecordReader& reader, std::vector<PublicKey>& keys) {
  const Result<PublicKey> key = public_key_from_base64(reader.take("key"));
  if (!key) reader.fail(key.error().message);
  if (key) keys.push_back(*key);
}

std::string lines_of(const std::vector<PublicKey>& keys) {
  std::string lines;
  for (const PublicKey& key : keys) lines += concat("key ", to_base64(key), "\n");
  return lines;
}

// "1.0": a major and a minor of the map's format.
void take_reader(RecordReader& reader, ReleaseRecord& record) {
  const std::string_view text = reader.take("minimum-reader");
  const std::size_t dot = text.find('.');
  if (dot == std::string_view::npos) return reader.fail("expected a format such as 1.0");
  const std::uint64_t major = reader.number(text.substr(0, dot));
  const std::uint64_t minor = reader.number(text.substr(dot + 1));
  if (major > UINT16_MAX || minor > UINT16_MAX) reader.fail("expected a format such as 1.0");
  record.minimum_major = static_cast<std::uint32_t>(major);
  record.minimum_minor = static_cast<std::uint32_t>(minor);
}

Result<void> check_files(const ReleaseRecord& record) {
  if (!is_safe_file_name(record.map.name)) {
    return Error{ErrorCode::kUnsafeName,
                 concat("\"", record.map.name, "\" is not a plain file name")};
  }
  if (record.deltas.size() > kMostDeltas) return malformed("more than 64 deltas");
  for (std::size_t i = 0; i < record.deltas.size(); ++i) {
    const ReleasedDelta& delta = record.deltas[i];
    if (!is_safe_file_name(delta.file.name)) {
      return Error{ErrorCode::kUnsafeName,
                   concat("\"", delta.file.name, "\" is not a plain file name")};
    }
    if (i > 0 && record.deltas[i - 1].base_sha256 >= delta.base_sha256) {
      return malformed("deltas must ascend by the digest of their base");
    }
  }
  return {};
}

// One signer under two names would count twice.
Result<void> check_keys(const std::vector<PublicKey>& keys) {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (!is_sound(keys[i])) {
      return malformed(concat(
          "key ", to_hex(keys[i].id),
          " is not a valid point of the curve: signatures by it could be forged. Make a new key"));
    }
    for (std::size_t k = 0; k < i; ++k) {
      if (keys[i].id == keys[k].id || keys[i].point == keys[k].point) {
        return malformed(concat("key ", to_hex(keys[i].id), " is listed twice"));
      }
    }
    if (i > 0 && to_base64(keys[i - 1]) > to_base64(keys[i])) {
      return malformed("keys must ascend by their text");
    }
  }
  return {};
}

bool is_before(const PublicKey& a, const PublicKey& b) { return to_base64(a) < to_base64(b); }

bool ascends(const std::vector<PublicKey>& keys) {
  return std::ranges::adjacent_find(keys, std::not_fn(is_before)) == keys.end();
}

}  // namespace

Result<void> validate(const ReleaseRecord& record) {
  if (!is_record_name(record.fleet)) return malformed("the fleet needs a name");
  if (!is_record_name(record.map_id)) return malformed("the map id is not a plain name");
  if (!is_plain_text(record.version)) return malformed("the version is not plain text");
  if (record.counter == 0) return malformed("counters start at 1");
  if (utc_seconds(utc_text(record.expires_s)) != record.expires_s) {
    return malformed("the expiry must be between 1970 and 9999");
  }
  return check_files(record);
}

std::string encode(const ReleaseRecord& record) {
  std::string text =
      concat("sightline-release 1\nfleet ", record.fleet, "\nmap-id ", record.map_id, "\nversion ",
             record.version, "\ncounter ", record.counter, "\nexpires ", utc_text(record.expires_s),
             "\nminimum-reader ", record.minimum_major, ".", record.minimum_minor, "\nsensor ",
             to_hex(record.sensor), "\nmap-release ", record.map_release, "\nroot-digest ",
             to_hex(record.root_digest), "\nmap ", text_of(record.map), "\n");
  for (const ReleasedDelta& delta : record.deltas) {
    text += concat("delta ", text_of(delta.file), " ", to_hex(delta.base_sha256), "\n");
  }
  return text;
}

Result<ReleaseRecord> decode_release_record(std::string_view text) {
  RecordReader reader(text);
  ReleaseRecord record;
  take_kind(reader, "sightline-release");
  record.fleet = reader.take_name("fleet");
  record.map_id = reader.take_name("map-id");
  record.version = reader.take("version");
  record.counter = reader.take_number("counter");
  record.expires_s = reader.take_time("expires");
  take_reader(reader, record);
  record.sensor = reader.take_digest("sensor");
  record.map_release = reader.take_number("map-release");
  record.root_digest = reader.take_digest("root-digest");
  record.map = file_of(reader, reader.take_words("map", 3));
  while (reader.next_is("delta")) {
    const std::vector<std::string_view> words = reader.take_words("delta", 4);
    const ReleasedFile file = file_of(reader, words);
    record.deltas.push_back({file, reader.digest(words[3])});
    if (record.deltas.size() > kMostDeltas) reader.fail("more than 64 deltas");
  }
  SIGHTLINE_TRY(reader.finish());
  SIGHTLINE_TRY(validate(record));
  return record;
}

Result<ReleaseRecord> release_of_map(const std::filesystem::path& path) {
  SIGHTLINE_ASSIGN(const MappedFile file, MappedFile::open(path.string()));
  SIGHTLINE_ASSIGN(const MapContainer container, open_container(file.bytes()));
  CompiledMap map;
  SIGHTLINE_TRY(decode_manifest(*container.manifest, map));
  ReleaseRecord record;
  record.map_id = map.map_id;
  record.version = map.version;
  record.map_release = map.release;
  record.minimum_major = container.header.version.major;
  record.sensor = sensor_digest(map.sensor);
  record.root_digest = container.header.root_digest;
  record.map = {path.filename().string(), file.bytes().size(), sha256(file.bytes())};
  return record;
}

Digest sensor_digest(const SensorProfile& sensor) {
  ByteWriter writer;
  encode(sensor, writer);
  DigestBuilder builder;
  builder.add("sightline sensor");
  builder.add(writer.bytes());
  return builder.finish();
}

Result<void> validate(const RootRecord& record) {
  if (!is_record_name(record.fleet)) return malformed("the fleet needs a name");
  if (record.version == 0) return malformed("versions start at 1");
  if (utc_seconds(utc_text(record.expires_s)) != record.expires_s) {
    return malformed("the expiry must be between 1970 and 9999");
  }
  if (record.keys.empty() || record.keys.size() > kMostKeys) {
    return malformed(concat("found ", record.keys.size(), " keys, expected 1 to 16"));
  }
  if (record.threshold == 0 || record.threshold > record.keys.size()) {
    return malformed(
        concat("the threshold is ", record.threshold, " of ", record.keys.size(), " keys"));
  }
  return check_keys(record.keys);
}

std::string encode(const RootRecord& record) {
  return concat("sightline-root 1\nfleet ", record.fleet, "\nversion ", record.version,
                "\nexpires ", utc_text(record.expires_s), "\nthreshold ", record.threshold, "\n",
                lines_of(record.keys));
}

Result<RootRecord> decode_root_record(std::string_view text) {
  RecordReader reader(text);
  RootRecord record;
  take_kind(reader, "sightline-root");
  record.fleet = reader.take_name("fleet");
  record.version = reader.take_number("version");
  record.expires_s = reader.take_time("expires");
  const std::uint64_t threshold = reader.take_number("threshold");
  if (threshold > kMostKeys) reader.fail("a threshold beyond 16");
  record.threshold = static_cast<std::uint32_t>(threshold);
  while (reader.next_is("key")) {
    take_key(reader, record.keys);
    if (record.keys.size() > kMostKeys) reader.fail("more than 16 keys");
  }
  SIGHTLINE_TRY(reader.finish());
  SIGHTLINE_TRY(validate(record));
  return record;
}

std::string encode(const SeenState& state) {
  return concat("sightline-seen 1\ntime ", utc_text(state.time_s), "\n", lines_of(state.keys),
                state.release);
}

Result<SeenState> decode_seen_state(std::string_view text) {
  SeenState state;
  const std::size_t begin = text.find("sightline-release ");
  state.release = begin == std::string_view::npos ? "" : text.substr(begin);
  RecordReader reader(text.substr(0, begin));
  if (begin != 0) {
    take_kind(reader, "sightline-seen");
    state.time_s = reader.take_time("time");
    while (reader.next_is("key")) take_key(reader, state.keys);
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
