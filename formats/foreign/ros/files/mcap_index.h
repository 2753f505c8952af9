#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/base/result.h"
#include "formats/foreign/logs/random_access_file.h"
#include "formats/foreign/ros/files/bag_compression.h"
#include "formats/foreign/ros/files/mcap_record.h"

// What an MCAP file holds, without its messages.

namespace sightline {

// A chunk of records, as it lies in the file.
struct McapChunk {
  std::uint64_t offset = 0;       // of its record, bytes of the file
  std::uint64_t data_offset = 0;  // of what may be packed
  std::uint64_t data_size = 0;
  std::uint64_t unpacked_size = 0;
  std::uint32_t crc = 0;
  BagCompression compression = BagCompression::kNone;
  bool is_indexed = false;                                // the counts were said behind it
  std::map<std::uint16_t, std::uint64_t> message_counts;  // by channel
};

// A message outside of chunks.
struct McapLoneMessage {
  McapMessage message;
  std::uint64_t data_offset = 0;
  std::uint64_t data_size = 0;
};

struct McapIndex {
  std::map<std::uint16_t, McapSchema> schemas;
  std::map<std::uint16_t, McapChannel> channels;
  std::vector<McapChunk> chunks;  // ascending, none within another
  std::vector<McapLoneMessage> messages;
  std::optional<std::uint64_t> said_messages;  // how many the summary counts
  bool is_closed = false;  // the file has the end that its writer gives it at last

  // Takes a schema or a channel; false where it contradicts one of the same number, or is none.
  bool add(const McapRecord& record);
};

// Walks through the records of the file, but for what lies in chunks; what the summary at its end
// says of places is not needed. A file that was not closed may end behind any record. Errors:
// cannot-read, malformed-header, truncated-scan, unsupported-format; all with the byte.
Result<McapIndex> read_mcap_index(const RandomAccessFile& file);

// malformed-header at a byte of the file.
Error damaged_mcap(const RandomAccessFile& file, std::uint64_t offset, std::string message);

}  // namespace sightline
