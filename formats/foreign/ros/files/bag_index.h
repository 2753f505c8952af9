#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/result.h"
#include "formats/foreign/logs/random_access_file.h"
#include "formats/foreign/ros/files/bag_compression.h"
#include "formats/foreign/ros/files/message_log.h"

// What a ROS 1 bag holds, without its messages.

namespace sightline {

// A ROS 1 bag of format 2.0 is a line of text and records: a header and data, each behind its
// length in 32 bits; the header is a list of fields "name=value", each behind its length too.

// What a record is, by its field "op".
enum class BagOp : std::uint8_t {
  kMessage = 2,
  kBagHeader = 3,
  kIndexData = 4,
  kChunk = 5,
  kChunkInfo = 6,
  kConnection = 7
};

class BagFields {
 public:
  // Nothing for bytes that are no list of fields. Of two fields of one name the last one counts.
  static std::optional<BagFields> parse(std::span<const std::byte> bytes);

  // Nothing where there is no such field; a number has all bytes of its type and no more.
  [[nodiscard]] std::optional<std::string> text(std::string_view name) const;
  template <class T>
  [[nodiscard]] std::optional<T> number(std::string_view name) const {
    const auto found = values_.find(name);
    if (found == values_.end() || found->second.size() != sizeof(T)) return std::nullopt;
    T value{};
    std::memcpy(&value, found->second.data(), sizeof value);
    return value;
  }
  [[nodiscard]] bool is(BagOp op) const {
    return number<std::uint8_t>("op") == static_cast<std::uint8_t>(op);
  }
  // The field "time": ns since 1970.
  [[nodiscard]] std::optional<std::int64_t> time_ns() const;

 private:
  std::map<std::string, std::string, std::less<>> values_;
};

struct BagRecord {
  BagFields fields;
  std::span<const std::byte> data;
};

// The record at `offset` of bytes in memory, and sets `offset` behind it; nothing where there is
// none that lies within the bytes.
std::optional<BagRecord> take_bag_record(std::span<const std::byte> bytes, std::size_t& offset);

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

}  // namespace sightline
