#pragma once

#include <rosbag/bag.h>

#include <boost/make_shared.hpp>
#include <string>
#include <vector>

#include "tests/formats/foreign/foreign_files.h"

namespace sightline {

struct SerializedMessage {
  std::string bytes;
};

}  // namespace sightline

namespace ros {
namespace message_traits {
template <>
struct MD5Sum<sightline::SerializedMessage> {
  static const char* value(const sightline::SerializedMessage&) { return "*"; }
};
template <>
struct DataType<sightline::SerializedMessage> {
  static const char* value(const sightline::SerializedMessage&) { return "*"; }
};
template <>
struct Definition<sightline::SerializedMessage> {
  static const char* value(const sightline::SerializedMessage&) { return ""; }
};
}  // namespace message_traits
namespace serialization {
template <>
struct Serializer<sightline::SerializedMessage> {
  template <class Stream>
  static void write(Stream& stream, const sightline::SerializedMessage& message) {
    std::memcpy(stream.advance(static_cast<std::uint32_t>(message.bytes.size())),
                message.bytes.data(), message.bytes.size());
  }
  static std::uint32_t serializedLength(const sightline::SerializedMessage& message) {
    return static_cast<std::uint32_t>(message.bytes.size());
  }
};
}  // namespace serialization
}  // namespace ros

namespace sightline {

struct BagMessage {
  std::string topic;
  std::string type;
  std::uint32_t seconds = 0;  // of its recording
  std::uint32_t nanoseconds = 0;
  std::string bytes;
};

// In chunks of `chunk_bytes`, so that a small bag has several.
inline void write_bag(
    const std::filesystem::path& path, const std::vector<BagMessage>& messages,
    rosbag::compression::CompressionType compression = rosbag::compression::Uncompressed,
    std::uint32_t chunk_bytes = 100) {
  rosbag::Bag bag(path.string(), rosbag::bagmode::Write);
  bag.setCompression(compression);
  bag.setChunkThreshold(chunk_bytes);
  for (const BagMessage& message : messages) {
    auto connection = boost::make_shared<ros::M_string>();
    (*connection)["type"] = message.type;
    (*connection)["md5sum"] = "0123456789abcdef0123456789abcdef";
    (*connection)["message_definition"] = "";
    (*connection)["topic"] = message.topic;
    bag.write(message.topic, ros::Time(message.seconds, message.nanoseconds),
              SerializedMessage{message.bytes}, connection);
  }
  bag.close();
}

inline std::string ros_text(std::string_view word) {
  return as_bytes({static_cast<std::uint32_t>(word.size())}) + std::string(word);
}

inline std::string ros_header(std::uint32_t seconds, std::uint32_t nanoseconds,
                              std::string_view frame = "lidar") {
  return as_bytes({std::uint32_t{0}, seconds, nanoseconds}) + ros_text(frame);
}

struct BagField {
  std::string_view name;
  std::uint32_t offset;
  std::uint8_t type;  // as sensor_msgs/PointField numbers them
};

// `data` holds rows of `width` points of `step` bytes and `padding` bytes each.
inline std::string cloud_message(std::uint32_t seconds, std::uint32_t nanoseconds,
                                 const std::vector<BagField>& fields, std::uint32_t width,
                                 std::uint32_t step, const std::string& data,
                                 std::uint32_t padding = 0, bool is_bigendian = false) {
  const std::uint32_t row = width * step + padding;
  const auto height = static_cast<std::uint32_t>(data.size() / row);
  std::string bytes = ros_header(seconds, nanoseconds);
  bytes += as_bytes({height, width, static_cast<std::uint32_t>(fields.size())});
  for (const BagField& field : fields) {
    bytes += ros_text(field.name) + as_bytes({field.offset}) + as_bytes({field.type});
    bytes += as_bytes({std::uint32_t{1}});
  }
  bytes += static_cast<char>(is_bigendian ? 1 : 0);
  bytes += as_bytes({step, row}) + ros_text(data) + '\1';
  return bytes;
}

}  // namespace sightline
