#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "formats/base/result.h"
#include "formats/foreign/logs/random_access_file.h"
#include "formats/foreign/ros/files/bag_compression.h"
#include "formats/foreign/ros/files/bag_record.h"
#include "formats/foreign/ros/files/message_log.h"

// What a ROS 1 bag holds, without its messages.

namespace sightline {

// A chunk of records, as it lies in the file.
struct BagChunk {
  std::uint64_t offset = 0;       // of its record, bytes of the file
  std::uint64_t data_offset = 0;  // of what may be packed
  std::uint32_t data_size = 0;
  std::uint32_t unpacked_size = 0;
  BagCompression compression = BagCompression::kNone;
  std::map<std::uint32_t, std::uint32_t> message_counts;  // by connection
};

struct BagIndex {
  std::map<std::uint32_t, LogChannel> connections;
  std::vector<BagChunk> chunks;  // ascending, none within another
  // False: the bag was not closed and has no index; connections and counts are unknown.
  bool is_there = true;
};

// Errors: those of MessageLog.
Result<BagIndex> read_bag_index(const RandomAccessFile& file);

// A connection of a record kConnection, and its number; nothing where it lacks one of the two, a
// topic or a type.
struct NumberedConnection {
  std::uint32_t number = 0;
  LogChannel connection;
};
std::optional<NumberedConnection> connection_of(const BagFields& fields,
                                                std::span<const std::byte> data);

// malformed-header at a byte of the file.
Error damaged_bag(const RandomAccessFile& file, std::uint64_t offset, std::string message);

}  // namespace sightline
