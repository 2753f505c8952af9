#include "formats/foreign/ros/ros_bag.h"

#include <algorithm>
#include <map>
#include <utility>

#include "formats/foreign/ros/bag_topics.h"
#include "formats/foreign/ros/files/open_message_log.h"
#include "formats/foreign/ros/ros_messages.h"
#include "formats/foreign/ros/scan_messages.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

class BagScans : public ScanContainer {
 public:
  BagScans(fs::path path, std::unique_ptr<MessageLog> log)
      : path_(std::move(path)), log_(std::move(log)) {
    warnings_ = log_->warnings();
  }

  Result<void> build_index(const std::string& topic);
  Result<std::vector<std::byte>> read(std::size_t index) const override {
    return log_->read(messages_.at(index).place);
  }
  Result<PointCloudFile> parse(std::span<const std::byte> bytes, std::size_t index) const override {
    const LogChannel& channel = log_->channels().at(messages_.at(index).channel);
    return parse_scan_message(bytes, channel.type, name_of(index), *channel.encoding);
  }

 private:
  struct Found {
    std::int64_t time_ns = 0;
    std::uint32_t channel = 0;
    MessagePlace place;
    ContainedScan scan;
  };
  [[nodiscard]] std::string name_of(std::size_t index) const {
    return path_.string() + "#" + std::to_string(index);
  }
  Result<void> add(const LoggedMessage& message);

  fs::path path_;
  std::unique_ptr<MessageLog> log_;
  std::vector<Found> messages_;
};

// A header's stamp, or the time of its recording where the driver left it at zero.
Result<void> BagScans::add(const LoggedMessage& message) {
  const MessageEncoding encoding = *log_->channels().at(message.channel).encoding;
  SIGHTLINE_ASSIGN(const MessageHeader header,
                   header_of(message.bytes, encoding, name_of(messages_.size())));
  if (messages_.empty()) frame_ = header.frame;
  const std::int64_t stamp_ns = header.stamp_ns != 0 ? header.stamp_ns : message.time_ns;
  messages_.push_back(
      {message.time_ns, message.channel, message.place, {stamp_ns, sha256(message.bytes)}});
  return {};
}

Result<void> BagScans::build_index(const std::string& topic) {
  SIGHTLINE_ASSIGN(const std::string chosen,
                   choose_topic(path_, topics_of(*log_, &is_scan_message), topic));
  SIGHTLINE_TRY(log_->for_each_message(channels_of(*log_, chosen, &is_scan_message),
                                       [&](const LoggedMessage& message) { return add(message); }));
  std::ranges::stable_sort(messages_, {}, &Found::time_ns);
  for (const Found& message : messages_) scans_.push_back(message.scan);
  return {};
}

struct TimedPose {
  std::int64_t time_ns = 0;  // of its recording
  PoseRow row;
};

// In the order of their recording.
Result<std::vector<TimedPose>> timed_poses(const fs::path& path, const MessageLog& log,
                                           const std::string& topic) {
  std::vector<TimedPose> poses;
  SIGHTLINE_TRY(log.for_each_message(
      channels_of(log, topic, &is_pose_message), [&](const LoggedMessage& message) -> Result<void> {
        const LogChannel& channel = log.channels().at(message.channel);
        SIGHTLINE_ASSIGN(const PoseRow row, parse_pose_message(message.bytes, channel.type,
                                                               path.string(), *channel.encoding));
        poses.push_back({message.time_ns, row});
        return {};
      }));
  std::ranges::stable_sort(poses, {}, &TimedPose::time_ns);
  return poses;
}

Result<std::vector<PoseRow>> poses_of_topic(const fs::path& path, const MessageLog& log,
                                            const std::string& topic) {
  SIGHTLINE_ASSIGN(const std::vector<TimedPose> poses, timed_poses(path, log, topic));
  std::vector<PoseRow> rows;
  for (const TimedPose& pose : poses) {
    const PoseRow& row = pose.row;
    if (!rows.empty() && *row.stamp_ns == *rows.back().stamp_ns) continue;  // said twice
    if (!rows.empty() && *row.stamp_ns < *rows.back().stamp_ns) {
      return Error{ErrorCode::kTimeRunsBackwards,
                   "found time " + format_stamp(*row.stamp_ns) + " s after " +
                       format_stamp(*rows.back().stamp_ns) + " s",
                   path.string(), topic + " message " + std::to_string(rows.size())};
    }
    rows.push_back(row);
  }
  return rows;
}

bool is_fix_message(std::string_view type) { return type == kNavSatFix; }

std::string vehicle_frame(const TransformTree& tree) {
  const bool has_link = tree.has_frame("base_link") || !tree.has_frame("base_footprint");
  return has_link ? "base_link" : "base_footprint";
}

}  // namespace

Result<std::vector<BagTopic>> list_bag_topics(const fs::path& path) {
  SIGHTLINE_ASSIGN(const std::unique_ptr<MessageLog> log, open_message_log(path));
  std::map<std::string, BagTopic> topics;
  for (const auto& [number, channel] : log->channels()) {
    if (channel.message_count == 0) continue;
    BagTopic& topic = topics[channel.topic];
    topic.name = channel.topic;
    topic.type = channel.type;
    topic.message_count += channel.message_count;
  }
  std::vector<BagTopic> listed;
  for (auto& [name, topic] : topics) listed.push_back(std::move(topic));
  return listed;
}

bool is_ros_bag(const fs::path& path) { return is_message_log(path); }

Result<std::vector<PoseRow>> read_bag_poses(const fs::path& path, const std::string& topic,
                                            const std::string& frame) {
  SIGHTLINE_ASSIGN(const std::unique_ptr<MessageLog> log, open_message_log(path));
  const TopicChoice poses = topics_of(*log, &is_pose_message);
  const TopicChoice transforms = topics_of(*log, &is_transforms_message);
  const bool takes_transforms = topic.empty() ? poses.fitting.empty() && !transforms.fitting.empty()
                                              : transforms.fitting.contains(topic);
  if (!takes_transforms) {
    SIGHTLINE_ASSIGN(const std::string chosen, choose_topic(path, poses, topic));
    return poses_of_topic(path, *log, chosen);
  }
  SIGHTLINE_ASSIGN(const TransformTree tree, read_transforms(path, *log));
  return tree.poses_of(frame.empty() ? vehicle_frame(tree) : frame, path.string());
}

Result<std::optional<GeodeticTrack>> read_bag_fixes(const fs::path& path,
                                                    const std::string& topic) {
  SIGHTLINE_ASSIGN(const std::unique_ptr<MessageLog> log, open_message_log(path));
  const TopicChoice fixes = topics_of(*log, &is_fix_message);
  const bool is_alone = topics_of(*log, &is_pose_message).fitting.empty() &&
                        topics_of(*log, &is_transforms_message).fitting.empty() &&
                        fixes.fitting.size() == 1;
  if (topic.empty() ? !is_alone : !fixes.fitting.contains(topic)) {
    return std::optional<GeodeticTrack>();
  }
  const std::string& chosen = topic.empty() ? *fixes.fitting.begin() : topic;
  GeodeticTrack track;
  std::size_t without = 0;
  SIGHTLINE_TRY(log->for_each_message(
      channels_of(*log, chosen, &is_fix_message),
      [&](const LoggedMessage& message) -> Result<void> {
        const LogChannel& channel = log->channels().at(message.channel);
        SIGHTLINE_ASSIGN(const std::optional<GeodeticFix> fix,
                         parse_fix_message(message.bytes, path.string(), *channel.encoding));
        if (fix) track.fixes.push_back(*fix);
        without += fix ? 0 : 1;
        return {};
      }));
  const auto stamp = [](const GeodeticFix& fix) { return *fix.stamp_ns; };
  std::ranges::stable_sort(track.fixes, {}, stamp);
  const auto is_same_time = [&](const GeodeticFix& a, const GeodeticFix& b) {
    return stamp(a) == stamp(b);
  };
  track.fixes.erase(std::unique(track.fixes.begin(), track.fixes.end(), is_same_time),
                    track.fixes.end());
  if (without > 0) {
    track.warnings.push_back(path.string() + ": " + std::to_string(without) + " messages of " +
                             chosen + " have no fix and are skipped");
  }
  return std::optional<GeodeticTrack>(std::move(track));
}

Result<std::optional<Pose>> bag_mounting(const fs::path& path, const std::string& sensor_frame) {
  SIGHTLINE_ASSIGN(const std::unique_ptr<MessageLog> log, open_message_log(path));
  SIGHTLINE_ASSIGN(const TransformTree tree, read_transforms(path, *log));
  return tree.fixed_pose(vehicle_frame(tree), sensor_frame);
}

Result<std::shared_ptr<const ScanContainer>> open_bag(const fs::path& path,
                                                      const std::string& topic) {
  SIGHTLINE_ASSIGN(std::unique_ptr<MessageLog> log, open_message_log(path));
  auto scans = std::make_shared<BagScans>(path, std::move(log));
  SIGHTLINE_TRY(scans->build_index(topic));
  return std::shared_ptr<const ScanContainer>(std::move(scans));
}

}  // namespace sightline
