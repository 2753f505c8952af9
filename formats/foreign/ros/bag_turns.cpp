#include "formats/foreign/ros/bag_turns.h"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>
#include <utility>

#include "formats/foreign/ros/bag_topics.h"
#include "formats/foreign/ros/files/open_message_log.h"
#include "formats/foreign/ros/ros_messages.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

// The messages of one topic that say something, in the order of the file.
struct ImuTopic {
  std::string name;
  std::string frame;  // of its first message
  struct Sample {
    std::int64_t recorded_ns = 0;
    TurnRate of_imu;  // about the axes of its own frame
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
        topic.samples.push_back({message.time_ns, {stamp_ns, imu->rate_rad_per_s}});
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
  }
  std::size_t backwards = 0;
  for (std::size_t i = 1; i < turns.of_sensor.size(); ++i) {
    backwards += stamp(turns.of_sensor[i]) < stamp(turns.of_sensor[i - 1]) ? 1 : 0;
  }
  std::ranges::stable_sort(turns.of_sensor, {}, stamp);
  const std::size_t all = turns.of_sensor.size();
  const auto is_same_time = [&](const TurnRate& a, const TurnRate& b) {
    return stamp(a) == stamp(b);
  };
  turns.of_sensor.erase(std::unique(turns.of_sensor.begin(), turns.of_sensor.end(), is_same_time),
                        turns.of_sensor.end());
  const std::size_t twice = all - turns.of_sensor.size();
  const auto warn = [&](std::size_t count, const std::string& what) {
    if (count == 0) return;
    turns.warnings.push_back(topic.name + ": " + std::to_string(count) + " of " +
                             std::to_string(all + topic.unusable) + " messages " + what);
  };
  warn(topic.unusable, "are damaged or have no angular velocity and are skipped");
  warn(backwards, "are stamped before the one recorded before them; they are put in order");
  warn(twice, "have the stamp of another one and are skipped");
}

std::string names_of(const std::vector<ImuTopic>& topics) {
  std::string names;
  for (const ImuTopic& topic : topics) {
    names += (names.empty() ? "" : ", ") + topic.name + " (frame '" + topic.frame + "', " +
             std::to_string(topic.samples.size()) + " messages)";
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
    turns.warnings.push_back("turn rates are not used: no transforms that do not move tell how " +
                             names_of(topics) + " lies to the scans' frame '" + sensor_frame + "'");
    return turns;
  }
  if (topics.size() > 1) {
    turns.warnings.push_back("turn rates are those of " + chosen->name + "; the bag has " +
                             names_of(topics) + ": name another as imu_topic");
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

Result<BagTurns> read_bag_turns(const fs::path& path, const std::string& topic,
                                const std::string& sensor_frame) {
  Result<BagTurns> turns = read_turns(path, topic, sensor_frame);
  if (turns) {
    for (std::string& warning : turns->warnings) warning.insert(0, path.string() + ": ");
    return turns;
  }
  if (!topic.empty()) return turns;
  // Nobody asked for them, and the scans may well be read.
  BagTurns none;
  none.warnings.push_back("turn rates are not used: " + to_string(turns.error()));
  return none;
}

}  // namespace sightline
