#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/result.h"

namespace sightline {

// How the fields of a message follow each other.
enum class MessageEncoding {
  kRos1,  // without gaps, little-endian
  kCdr,   // of ROS 2: aligned, of either byte order
};

// The messages of one type on one topic.
struct LogChannel {
  std::string topic;
  std::string type;                         // "sensor_msgs/PointCloud2", of ROS 2 too
  std::optional<MessageEncoding> encoding;  // nothing: one that is not read here
  std::uint64_t message_count = 0;
};

// Where the bytes of one message lie.
struct MessagePlace {
  std::size_t file = 0;      // of a recording in several
  std::size_t chunk = 0;     // of that file
  std::uint64_t offset = 0;  // in the unpacked chunk or in the file; of a database the row
  std::size_t size = 0;
};

struct LoggedMessage {
  std::uint32_t channel = 0;
  std::int64_t time_ns = 0;  // of its recording
  MessagePlace place;
  std::span<const std::byte> bytes;
};

// A recording of messages. Every length is checked against the file before memory is asked for.
// Errors of all functions: cannot-read; malformed-header (the file contradicts itself),
// truncated-scan (it ends before what it promises), unsupported-format.
class MessageLog {
 public:
  virtual ~MessageLog() = default;

  // By number.
  [[nodiscard]] const std::map<std::uint32_t, LogChannel>& channels() const { return channels_; }
  // What is doubtful, for the person who brought the file.
  [[nodiscard]] const std::vector<std::string>& warnings() const { return warnings_; }

  // Calls body(message) for every message of these channels, in the order of the file; the bytes
  // are there during the call.
  using MessageBody = std::function<Result<void>(const LoggedMessage&)>;
  virtual Result<void> for_each_message(const std::set<std::uint32_t>& channels,
                                        const MessageBody& body) const = 0;
  // The bytes of a message that for_each_message gave. Safe from several threads.
  virtual Result<std::vector<std::byte>> read(const MessagePlace& place) const = 0;

 protected:
  std::map<std::uint32_t, LogChannel> channels_;
  std::vector<std::string> warnings_;
};

// Whether open_message_log is the one to ask, by the first bytes: a ROS 1 bag, an MCAP file, a .db3
// of rosbag2 or the folder with its metadata.yaml.
bool is_message_log(const std::filesystem::path& path);

// Opens one of them. The files of a folder are one recording in the order of its metadata; messages
// of ROS 2 that are packed one by one (zstd) are given unpacked. Errors: those of MessageLog;
// file-not-found, cannot-open.
Result<std::unique_ptr<MessageLog>> open_message_log(const std::filesystem::path& path);

// The kinds of files behind open_message_log(); not for other folders.

// Opens a ROS 1 bag of format 2.0 (chunks none, bz2 or lz4), also one that was not closed. Holds
// the index and one chunk, packed and unpacked (most_unpacked). Errors: those of MessageLog, with
// the byte; cannot-open; unsupported-format (another version or compression, encrypted).
Result<std::unique_ptr<MessageLog>> open_ros1_bag(const std::filesystem::path& path);

// Whether a file begins like MCAP.
bool is_mcap(const std::filesystem::path& path);

// Opens an MCAP file of ROS 1 or ROS 2, with chunks (none, lz4, zstd) and an index or without.
// Holds the index and one chunk, packed and unpacked (most_unpacked). Checksums are verified. A
// file that was not closed, or holds other messages than its summary counts, gives a warning.
// Errors: those of MessageLog, with the byte; cannot-open.
Result<std::unique_ptr<MessageLog>> open_mcap(const std::filesystem::path& path);

// Whether a file begins like a database of SQLite that names no application of its own: a .db3 of
// rosbag2.
bool is_db3(const std::filesystem::path& path);

// Opens a .db3 as rosbag2 writes it, read-only. Errors: those of MessageLog and SqliteFile;
// unsupported-format (a database without topics and messages).
Result<std::unique_ptr<MessageLog>> open_db3(const std::filesystem::path& path);

// "sensor_msgs/PointCloud2" for "sensor_msgs/msg/PointCloud2"; all others as they are.
inline std::string ros1_type_name(std::string_view type) {
  constexpr std::string_view kMiddle = "/msg/";
  const std::size_t at = type.find(kMiddle);
  if (at == std::string_view::npos) return std::string(type);
  return std::string(type.substr(0, at + 1)).append(type.substr(at + kMiddle.size()));
}

// "cdr" or "ros1", as MCAP and rosbag2 name them; nothing for any other.
inline std::optional<MessageEncoding> encoding_named(std::string_view name) {
  if (name == "cdr") return MessageEncoding::kCdr;
  if (name == "ros1") return MessageEncoding::kRos1;
  return std::nullopt;
}

}  // namespace sightline
