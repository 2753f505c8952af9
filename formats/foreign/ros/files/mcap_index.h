#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/base/result.h"
#include "formats/foreign/logs/random_access_file.h"
#include "formats/foreign/ros/files/bag_compression.h"

// What an MCAP file holds, without its messages.

namespace sightline {

// The records of an MCAP file (mcap.dev/spec): a kind in one byte, the length of what follows in
// 64 bits, and fields one after the other, little-endian, strings behind a 32-bit length.

enum class McapOp : std::uint8_t {
  kHeader = 1,
  kFooter = 2,
  kSchema = 3,
  kChannel = 4,
  kMessage = 5,
  kChunk = 6,
  kMessageIndex = 7,
  kStatistics = 11,
  kDataEnd = 15
};

inline constexpr std::size_t kMcapPrefixSize = 9;  // of a record: kind and length

// A record in memory.
struct McapRecord {
  McapOp op{};
  std::span<const std::byte> data;
};
// The record at `offset` of bytes, and sets `offset` behind it; nothing where there is none that
// lies within the bytes.
std::optional<McapRecord> take_mcap_record(std::span<const std::byte> bytes, std::size_t& offset);

struct McapSchema {
  std::uint16_t id = 0;
  std::string name;  // "sensor_msgs/msg/PointCloud2"
  auto operator<=>(const McapSchema&) const = default;
};
struct McapChannel {
  std::uint16_t id = 0;
  std::uint16_t schema_id = 0;  // 0: none
  std::string topic;
  std::string encoding;  // "cdr", "ros1"
  auto operator<=>(const McapChannel&) const = default;
};
struct McapMessage {
  static constexpr std::size_t kHeaderSize = 22;
  std::uint16_t channel_id = 0;
  std::int64_t log_time_ns = 0;
};

// Nothing for data that are cut.
std::optional<McapMessage> mcap_message(std::span<const std::byte> data);

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

}  // namespace sightline
