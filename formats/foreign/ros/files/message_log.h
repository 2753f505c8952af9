#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "formats/base/result.h"

// What the recordings of ROS 1 and ROS 2 have in common, whatever their file.

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

}  // namespace sightline
