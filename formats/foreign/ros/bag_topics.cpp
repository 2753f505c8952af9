#include "formats/foreign/ros/bag_topics.h"

#include <utility>
#include <vector>

#include "formats/foreign/ros/ros_messages.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

Error error_of(const fs::path& path, ErrorCode code, std::string message) {
  return {code, std::move(message), path.string()};
}

}  // namespace

TopicChoice topics_of(const MessageLog& log, TypeTest is_type) {
  TopicChoice choice;
  for (const auto& [number, channel] : log.channels()) {
    if (channel.message_count == 0) continue;
    if (channel.encoding && is_type(channel.type)) choice.fitting.insert(channel.topic);
    choice.all += " " + channel.topic + " (" + channel.type +
                  (channel.encoding ? ")" : ", neither in CDR nor in the form of ROS 1)");
  }
  return choice;
}

// The topic to read: the one that is named, or the only one of a type that is wanted.
Result<std::string> choose_topic(const fs::path& path, const TopicChoice& topics,
                                 const std::string& wanted) {
  if (topics.fitting.contains(wanted)) return wanted;
  if (!wanted.empty()) {
    return error_of(
        path, ErrorCode::kUnknownName,
        "no topic '" + wanted + "' of a type that is read here; the bag has:" + topics.all);
  }
  if (topics.fitting.size() == 1) return *topics.fitting.begin();
  if (topics.fitting.empty()) {
    return error_of(
        path, ErrorCode::kUnsupportedFormat,
        "no topic of a type that is read here; the bag has:" + topics.all +
            "; play it to the sensor's driver and record the sensor_msgs/PointCloud2 that "
            "comes out (packets and single lines of a scan are not read)");
  }
  return error_of(path, ErrorCode::kBadValue,
                  "several topics to choose from, name one of them; the bag has:" + topics.all);
}

std::set<std::uint32_t> channels_of(const MessageLog& log, const std::string& topic,
                                    TypeTest is_type) {
  std::set<std::uint32_t> numbers;
  for (const auto& [number, channel] : log.channels()) {
    const bool is_wanted = topic.empty() || channel.topic == topic;
    if (is_wanted && channel.encoding && is_type(channel.type)) numbers.insert(number);
  }
  return numbers;
}

Result<TransformTree> read_transforms(const fs::path& path, const MessageLog& log) {
  TransformTree tree;
  SIGHTLINE_TRY(log.for_each_message(
      channels_of(log, "", &is_transforms_message),
      [&](const LoggedMessage& message) -> Result<void> {
        const LogChannel& channel = log.channels().at(message.channel);
        SIGHTLINE_ASSIGN(const std::vector<StampedTransform> transforms,
                         parse_transforms(message.bytes, path.string(), *channel.encoding));
        const bool is_static = channel.topic.ends_with("tf_static");
        for (const StampedTransform& transform : transforms) tree.add(transform, is_static);
        return {};
      }));
  return tree;
}

}  // namespace sightline
