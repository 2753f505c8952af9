#include "formats/foreign/ros/ros_bag.h"

#include <algorithm>
#include <cstddef>
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

  Result<void> build_index(const std::string& topic) {
    SIGHTLINE_ASSIGN(const std::string chosen,
                     choose_topic(path_, topics_of(*log_, &is_scan_message), topic));
    SIGHTLINE_TRY(
        log_->for_each_message(channels_of(*log_, chosen, &is_scan_message),
                               [&](const LoggedMessage& message) { return add(message); }));
    std::ranges::stable_sort(messages_, {}, &Found::time_ns);
    for (const Found& message : messages_) scans_.push_back(message.scan);
    return {};
  }

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
    return concat(path_.string(), "#", index);
  }

  // A header's stamp, or the time of its recording where the driver left it at zero.
  Result<void> add(const LoggedMessage& message) {
    const MessageEncoding encoding = *log_->channels().at(message.channel).encoding;
    SIGHTLINE_ASSIGN(const MessageHeader header,
                     header_of(message.bytes, encoding, name_of(messages_.size())));
    if (messages_.empty()) frame_ = header.frame;
    const std::int64_t stamp_ns = header.stamp_ns != 0 ? header.stamp_ns : message.time_ns;
    messages_.push_back(
        {message.time_ns, message.channel, message.place, {stamp_ns, sha256(message.bytes)}});
    return {};
  }

  fs::path path_;
  std::unique_ptr<MessageLog> log_;
  std::vector<Found> messages_;
};

struct TimedPose {
  std::int64_t time_ns = 0;  // of its recording
  PoseRow row;
  std::string world_frame;
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
        SIGHTLINE_ASSIGN(const MessageHeader header,
                         header_of(message.bytes, *channel.encoding, path.string()));
        poses.push_back({message.time_ns, row, header.frame});
        return {};
      }));
  std::ranges::stable_sort(poses, {}, &TimedPose::time_ns);
  return poses;
}

Result<std::vector<PoseRow>> poses_of_topic(const fs::path& path, const MessageLog& log,
                                            const std::string& topic, std::string* world_frame) {
  SIGHTLINE_ASSIGN(const std::vector<TimedPose> poses, timed_poses(path, log, topic));
  if (world_frame != nullptr && !poses.empty()) *world_frame = poses.front().world_frame;
  std::vector<PoseRow> rows;
  for (const TimedPose& pose : poses) {
    const PoseRow& row = pose.row;
    if (!rows.empty() && *row.stamp_ns == *rows.back().stamp_ns) continue;  // said twice
    if (!rows.empty() && *row.stamp_ns < *rows.back().stamp_ns) {
      return Error{ErrorCode::kTimeRunsBackwards,
                   concat("found time ", format_stamp(*row.stamp_ns), " s after ",
                          format_stamp(*rows.back().stamp_ns), " s"),
                   path.string(), concat(topic, " message ", rows.size())};
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

namespace fs = std::filesystem;

// The messages of one topic that say something, in the order of the file.
struct ImuTopic {
  std::string name;
  std::string frame;  // of its first message
  struct Sample {
    std::int64_t recorded_ns = 0;
    TurnRate of_imu;  // about the axes of its own frame
    std::optional<Eigen::Vector3d> force_m_s2;
  };
  std::vector<Sample> samples;
  std::size_t unusable = 0;
};

bool is_imu_message(std::string_view type) { return type == kImu; }

Result<ImuTopic> read_topic(const MessageLog& log, const std::string& name) {
  ImuTopic topic;
  topic.name = name;
  SIGHTLINE_TRY(log.for_each_message(
      channels_of(log, name, &is_imu_message), [&](const LoggedMessage& message) -> Result<void> {
        const LogChannel& channel = log.channels().at(message.channel);
        const std::optional<ImuMessage> imu = parse_imu_message(message.bytes, *channel.encoding);
        topic.unusable += imu ? 0 : 1;
        if (!imu) return {};
        if (topic.samples.empty()) topic.frame = imu->header.frame;
        const std::int64_t stamp_ns =
            imu->header.stamp_ns != 0 ? imu->header.stamp_ns : message.time_ns;
        topic.samples.push_back(
            {message.time_ns, {stamp_ns, imu->rate_rad_per_s}, imu->force_m_s2});
        return {};
      }));
  std::ranges::stable_sort(topic.samples, {}, &ImuTopic::Sample::recorded_ns);
  return topic;
}

// The rotation from an inertial unit's frame to the sensor's.
std::optional<Eigen::Matrix3d> R_sensor_imu(const TransformTree& tree, const std::string& sensor,
                                            const std::string& imu) {
  if (sensor == imu) return Eigen::Matrix3d(Eigen::Matrix3d::Identity());
  const std::optional<Pose> T_sensor_imu = tree.fixed_between(sensor, imu);
  if (!T_sensor_imu) return std::nullopt;
  return Eigen::Matrix3d(T_sensor_imu->linear());
}

void take_samples(const ImuTopic& topic, const Eigen::Matrix3d& R_sensor_imu, BagTurns& turns) {
  const auto stamp = [](const TurnRate& rate) { return rate.stamp_ns; };
  for (const ImuTopic::Sample& sample : topic.samples) {
    const Eigen::Vector3d of_sensor = R_sensor_imu * sample.of_imu.rate_rad_per_s;
    turns.of_sensor.push_back({sample.of_imu.stamp_ns, of_sensor});
    if (!sample.force_m_s2) continue;
    turns.forces_of_sensor.push_back({sample.of_imu.stamp_ns, R_sensor_imu * *sample.force_m_s2});
  }
  std::size_t backwards = 0;
  for (std::size_t i = 1; i < turns.of_sensor.size(); ++i) {
    backwards += stamp(turns.of_sensor[i]) < stamp(turns.of_sensor[i - 1]) ? 1 : 0;
  }
  const std::size_t all = turns.of_sensor.size();
  sort_once(turns.of_sensor, stamp);
  sort_once(turns.forces_of_sensor, [](const SpecificForce& force) { return force.stamp_ns; });
  const std::size_t twice = all - turns.of_sensor.size();
  const auto warn = [&](std::size_t count, const std::string& what) {
    if (count == 0) return;
    turns.warnings.push_back(
        concat(topic.name, ": ", count, " of ", all + topic.unusable, " messages ", what));
  };
  warn(topic.unusable, "are damaged or have no angular velocity and are skipped");
  warn(backwards, "have times before that of the previous message; they are sorted");
  warn(twice, "have the time of another message and are skipped");
}

std::string names_of(const std::vector<ImuTopic>& topics) {
  std::string names;
  for (const ImuTopic& topic : topics) {
    names += concat((names.empty() ? "" : ", "), topic.name, " (frame '", topic.frame, "', ",
                    topic.samples.size(), " messages)");
  }
  return names;
}

BagTurns choose(const std::vector<ImuTopic>& topics, const TransformTree& tree,
                const std::string& sensor_frame) {
  BagTurns turns;
  const ImuTopic* chosen = nullptr;
  for (const ImuTopic& topic : topics) {
    const bool is_more = !chosen || topic.samples.size() > chosen->samples.size();
    if (!topic.samples.empty() && is_more && R_sensor_imu(tree, sensor_frame, topic.frame)) {
      chosen = &topic;
    }
  }
  if (!chosen) {
    turns.warnings.push_back(
        concat("turn rates are not used: no static transforms give the pose of ", names_of(topics),
               " in the scans' frame '", sensor_frame, "'"));
    return turns;
  }
  if (topics.size() > 1) {
    turns.warnings.push_back(concat("turn rates are taken from ", chosen->name, "; the bag has ",
                                    names_of(topics), ": to use another, name it as imu_topic"));
  }
  turns.topic = chosen->name;
  take_samples(*chosen, *R_sensor_imu(tree, sensor_frame, chosen->frame), turns);
  return turns;
}

Result<BagTurns> read_turns(const fs::path& path, const std::string& wanted,
                            const std::string& sensor_frame) {
  SIGHTLINE_ASSIGN(const std::unique_ptr<MessageLog> log, open_message_log(path));
  TopicChoice names = topics_of(*log, &is_imu_message);
  if (!wanted.empty()) {
    SIGHTLINE_ASSIGN(const std::string name, choose_topic(path, names, wanted));
    names.fitting = {name};
  }
  if (names.fitting.empty()) return BagTurns();
  std::vector<ImuTopic> topics;
  for (const std::string& name : names.fitting) {
    SIGHTLINE_ASSIGN(ImuTopic topic, read_topic(*log, name));
    topics.push_back(std::move(topic));
  }
  SIGHTLINE_ASSIGN(const TransformTree tree, read_transforms(path, *log));
  return choose(topics, tree, sensor_frame);
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
                                            const std::string& frame, std::string* world_frame) {
  SIGHTLINE_ASSIGN(const std::unique_ptr<MessageLog> log, open_message_log(path));
  const TopicChoice poses = topics_of(*log, &is_pose_message);
  const TopicChoice transforms = topics_of(*log, &is_transforms_message);
  const bool takes_transforms = topic.empty() ? poses.fitting.empty() && !transforms.fitting.empty()
                                              : transforms.fitting.contains(topic);
  if (!takes_transforms) {
    SIGHTLINE_ASSIGN(const std::string chosen, choose_topic(path, poses, topic));
    return poses_of_topic(path, *log, chosen, world_frame);
  }
  SIGHTLINE_ASSIGN(const TransformTree tree, read_transforms(path, *log));
  const std::string moving = frame.empty() ? vehicle_frame(tree) : frame;
  if (world_frame != nullptr) *world_frame = tree.frame_above(moving);
  return tree.poses_of(moving, path.string());
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
  sort_once(track.fixes, [](const GeodeticFix& fix) { return *fix.stamp_ns; });
  if (without > 0) {
    track.warnings.push_back(concat(path.string(), ": ", without, " messages of ", chosen,
                                    " have no fix and are skipped"));
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

Result<BagTurns> read_bag_turns(const fs::path& path, const std::string& topic,
                                const std::string& sensor_frame) {
  Result<BagTurns> turns = read_turns(path, topic, sensor_frame);
  if (turns) {
    for (std::string& warning : turns->warnings) warning.insert(0, path.string() + ": ");
    return turns;
  }
  if (!topic.empty()) return turns;
  // They are optional, and the scans can still be read.
  BagTurns none;
  none.warnings.push_back("turn rates are not used: " + to_string(turns.error()));
  return none;
}

}  // namespace sightline
