#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/result.h"
#include "formats/release/signing_key.h"

namespace sightline {

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

}  // namespace sightline
