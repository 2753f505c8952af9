#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/base/bytes.h"
#include "formats/base/result.h"

namespace sightline {

// A message type: "geometry_msgs/msg/PoseStamped" and its definition with those of its parts, in
// the language of .msg files; of other encodings of mcap.dev/spec/registry: "foxglove.PoseInFrame"
// and its JSON schema ("jsonschema", "json").
struct McapType {
  std::string_view name;
  std::string_view definition;
  std::string_view definition_encoding = "ros2msg";
  std::string_view message_encoding = "cdr";
};

// Writes an MCAP file (mcap.dev/spec): chunks that are not packed, so that equal messages give
// equal bytes whatever libraries there are, each with its index; checksums of chunks, data and
// summary; a summary with types, topics, counts and the index of chunks. Memory holds one chunk.
class McapWriter {
 public:
  // Gives all bytes to `file`, which must outlive the writer, as `profile`. "ros2": all messages
  // are of ROS 2; "": they are not.
  explicit McapWriter(const ByteSink& file, std::string_view profile = "ros2")
      : file_(file), profile_(profile) {}

  // A topic, before its first message; topics of one type share it. Returns its number.
  std::uint16_t add_topic(const std::string& topic, const McapType& type);

  // In any order of times. Error: that of the file.
  Result<void> add(std::uint16_t topic, std::int64_t time_ns, std::span<const std::byte> message);

  // The end of the file; nothing is added behind it. Error: that of the file.
  Result<void> finish();

 private:
  struct Type {
    std::string name;
    std::vector<std::byte> record;
  };
  struct Topic {
    std::vector<std::byte> record;
    std::uint64_t message_count = 0;
    std::vector<std::pair<std::int64_t, std::uint64_t>> in_chunk;  // times and places of messages
  };
  struct TimeSpan {
    std::int64_t first_ns = 0;
    std::int64_t last_ns = 0;
    bool is_empty = true;
    void add(std::int64_t time_ns);
  };

  Result<void> begin();
  Result<void> put(std::span<const std::byte> bytes);
  Result<void> end_chunk();
  [[nodiscard]] std::vector<std::byte> chunk_record() const;
  // The index of a topic's messages in the chunk, which it forgets.
  static std::vector<std::byte> take_index(std::uint16_t id, Topic& topic);
  [[nodiscard]] std::vector<std::byte> statistics() const;
  // Behind the data, without its checksum.
  [[nodiscard]] std::vector<std::byte> summary() const;

  const ByteSink& file_;
  std::string_view profile_;
  std::uint64_t size_ = 0;  // written
  std::uint32_t crc_ = 0;   // of all that was written
  std::vector<Type> types_;
  std::vector<Topic> topics_;
  std::vector<std::byte> chunk_;
  TimeSpan chunk_times_;
  TimeSpan times_;
  std::vector<std::vector<std::byte>> chunk_indexes_;
};

}  // namespace sightline
