#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/hash.h"
#include "formats/base/result.h"
#include "formats/drive/sensor_profile.h"
#include "formats/release/record_text.h"
#include "formats/release/signing_key.h"

namespace sightline {

inline constexpr std::size_t kMostDeltas = 64;

// A file that a vehicle may fetch, and all that it needs to know before the first byte arrives.
struct ReleasedFile {
  std::string name;  // is_safe_file_name()
  std::uint64_t size = 0;
  Digest sha256{};
  friend bool operator==(const ReleasedFile&, const ReleasedFile&) = default;
};

struct ReleasedDelta {
  ReleasedFile file;
  Digest base_sha256{};  // of the whole map file that it turns into the released one
  friend bool operator==(const ReleasedDelta&, const ReleasedDelta&) = default;
};

// Which map a fleet should drive with (schemas/release_format.md).
struct ReleaseRecord {
  std::string fleet;
  std::string map_id;
  std::string version;              // for people
  std::uint64_t counter = 1;        // of records: only ever grows
  std::int64_t expires_s = 0;       // UTC, since 1970
  std::uint32_t minimum_major = 1;  // the map format that a reader must know
  std::uint32_t minimum_minor = 0;
  Digest sensor{};                // sensor_digest()
  std::uint64_t map_release = 1;  // of the map's manifest
  Digest root_digest{};           // of the map
  ReleasedFile map;
  std::vector<ReleasedDelta> deltas;  // ascending by base, no base twice
  friend bool operator==(const ReleaseRecord&, const ReleaseRecord&) = default;
};

// Every promise above. Errors: malformed-record, unsafe-name.
Result<void> validate(const ReleaseRecord& record);

// Of a valid record. decode reads what encode writes and nothing else: a record that decodes
// encodes to the same bytes. Errors: malformed-record, unsafe-name, naming the line.
std::string encode(const ReleaseRecord& record);
Result<ReleaseRecord> decode_release_record(std::string_view text);

// The lines of a record that a map file itself fills: its manifest's and its own size and digest,
// under its own name. Errors: those of open_container(); file-not-found, cannot-open, cannot-read.
Result<ReleaseRecord> release_of_map(const std::filesystem::path& path);

// SHA-256 of all that a map says of its sensor: a vehicle with another one must not use the map.
Digest sensor_digest(const SensorProfile& sensor);

inline constexpr std::size_t kMostKeys = 16;

// Who may sign for a fleet, and how many of them it takes (schemas/release_format.md).
struct RootRecord {
  std::string fleet;
  std::uint64_t version = 1;   // the next root is this one plus 1
  std::int64_t expires_s = 0;  // UTC, since 1970
  std::uint32_t threshold = 1;
  std::vector<PublicKey> keys;  // ascending by their text; no id and no point twice, all is_sound()
};

// Every promise above. Error: malformed-record.
Result<void> validate(const RootRecord& record);

// Of a valid record. decode() reads what encode() writes and nothing else: a record that decodes
// encodes to the same bytes. Error: malformed-record, naming the line.
std::string encode(const RootRecord& record);
Result<RootRecord> decode_root_record(std::string_view text);

inline constexpr std::size_t kMostSeenKeys = 512;
inline constexpr std::size_t kLargestSeenState = 2 * kLargestRecord;

// What a vehicle remembers of the releases it admitted (schemas/release_format.md, "What a vehicle
// remembers"). It is not signed: it is on the vehicle's own disk.
struct SeenState {
  std::int64_t time_s = 0;      // UTC since 1970: it has not been earlier since
  std::vector<PublicKey> keys;  // of all roots that it admitted releases under; ascending by text
  std::string release;          // the record with the greatest counter, byte for byte
};

// Of a state with a release. decode_seen_state reads what encode writes, and a release record alone
// as a state without time and keys. Errors: those of decode_release_record; malformed-record, also
// for no text at all.
std::string encode(const SeenState& state);
Result<SeenState> decode_seen_state(std::string_view text);

// Adds keys of a root; those beyond kMostSeenKeys are not kept.
void add_keys(const std::vector<PublicKey>& keys, SeenState& state);

}  // namespace sightline
