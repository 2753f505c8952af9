#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/result.h"
#include "formats/release/record_text.h"
#include "formats/release/signing_key.h"

namespace sightline {

inline constexpr std::size_t kMostSeenKeys = 512;
inline constexpr std::size_t kLargestSeenState = 2 * kLargestRecord;

// What a vehicle remembers of the releases it admitted (schemas/release_format.md, "What a vehicle
// remembers"). Nobody signs it: it lies on the vehicle's own disk.
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
