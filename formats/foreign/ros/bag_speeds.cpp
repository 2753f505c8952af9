#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "formats/foreign/ros/bag_topics.h"
#include "formats/foreign/ros/files/open_message_log.h"
#include "formats/foreign/ros/ros_bag.h"
#include "formats/foreign/ros/ros_messages.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

// More odd messages of a topic than this are no accident.
constexpr double kMostOdd = 0.05;

// The messages of one topic, in the order of their recording.
struct SpeedTopic {
  std::string name;
  std::string type;
  struct Sample {
    std::int64_t recorded_ns = 0;
    std::optional<WheelSpeed> speed;  // none: it cannot be read
  };
  std::vector<Sample> samples;
  bool moves = false;  // any speed is other than zero
};

Result<SpeedTopic> read_speed_topic(const MessageLog& log, const std::string& name) {
  SpeedTopic topic;
  topic.name = name;
  SIGHTLINE_TRY(log.for_each_message(
      channels_of(log, name, &is_speed_message), [&](const LoggedMessage& message) -> Result<void> {
        const LogChannel& channel = log.channels().at(message.channel);
        topic.type = channel.type;
        const std::optional<SpeedMessage> read =
            parse_speed_message(message.bytes, channel.type, *channel.encoding);
        topic.samples.push_back({message.time_ns, std::nullopt});
        if (!read) return {};
        const std::int64_t stamp_ns =
            read->header.stamp_ns != 0 ? read->header.stamp_ns : message.time_ns;
        topic.samples.back().speed = WheelSpeed{stamp_ns, read->speed_m_s};
        topic.moves = topic.moves || read->speed_m_s != 0.0;
        return {};
      }));
  std::ranges::stable_sort(topic.samples, {}, &SpeedTopic::Sample::recorded_ns);
  return topic;
}

// Messages of a topic with one fault.
struct OddMessages {
  std::size_t count = 0;
  std::size_t first = 0;

  void add(std::size_t number) {
    if (count++ == 0) first = number;
  }
};

// Few are a warning, more the error of `code`.
Result<void> check_odd(const OddMessages& odd, const SpeedTopic& topic, ErrorCode code,
                       const std::string& what, BagSpeeds& speeds) {
  if (odd.count == 0) return {};
  const std::size_t all = topic.samples.size();
  const std::string found = concat(odd.count, " of ", all, " messages ", what);
  if (static_cast<double>(odd.count) > kMostOdd * static_cast<double>(all)) {
    return Error{code, found, "", concat(topic.name, " message ", odd.first)};
  }
  speeds.warnings.push_back(concat(topic.name, ": ", found));
  return {};
}

Result<BagSpeeds> speeds_of(const SpeedTopic& topic) {
  BagSpeeds speeds;
  speeds.topic = topic.name;
  speeds.type = topic.type;
  OddMessages unreadable;
  OddMessages backwards;
  for (std::size_t i = 0; i < topic.samples.size(); ++i) {
    const std::optional<WheelSpeed>& speed = topic.samples[i].speed;
    if (!speed) {
      unreadable.add(i);
      continue;
    }
    if (!speeds.speeds.empty() && speed->stamp_ns < speeds.speeds.back().stamp_ns) backwards.add(i);
    speeds.speeds.push_back(*speed);
  }
  SIGHTLINE_TRY(check_odd(unreadable, topic, ErrorCode::kBadValue,
                          "are damaged or have no finite speed below 150 m/s and are skipped",
                          speeds));
  SIGHTLINE_TRY(check_odd(backwards, topic, ErrorCode::kTimeRunsBackwards,
                          "have times before that of the previous message; they are sorted",
                          speeds));
  sort_once(speeds.speeds, [](const WheelSpeed& speed) { return speed.stamp_ns; });
  return speeds;
}

// The only topic of those, else none with a remark.
std::optional<SpeedTopic> only_topic(const std::vector<SpeedTopic>& topics, std::string& remark) {
  if (topics.size() == 1) return topics.front();
  std::string names;
  for (const SpeedTopic& topic : topics) {
    names += concat((names.empty() ? "" : ", "), topic.name, " (", topic.type, ")");
  }
  remark = concat("several topics have speeds of the vehicle: ", names,
                  "; to use one, name it as wheel_speed");
  return std::nullopt;
}

Result<BagSpeeds> read_speeds(const fs::path& path, const std::string& wanted) {
  SIGHTLINE_ASSIGN(const std::unique_ptr<MessageLog> log, open_message_log(path));
  const TopicChoice names = topics_of(*log, &is_speed_message);
  if (!wanted.empty()) {
    SIGHTLINE_ASSIGN(const std::string name, choose_topic(path, names, wanted));
    SIGHTLINE_ASSIGN(const SpeedTopic topic, read_speed_topic(*log, name));
    return speeds_of(topic);
  }
  std::vector<SpeedTopic> of_speed;
  std::vector<SpeedTopic> of_odometry;
  for (const std::string& name : names.fitting) {
    SIGHTLINE_ASSIGN(SpeedTopic topic, read_speed_topic(*log, name));
    if (!topic.moves) continue;
    const bool is_odometry = topic.type == "nav_msgs/Odometry";
    (is_odometry ? of_odometry : of_speed).push_back(std::move(topic));
  }
  const std::vector<SpeedTopic>& topics = of_speed.empty() ? of_odometry : of_speed;
  BagSpeeds none;
  if (topics.empty()) return none;
  const std::optional<SpeedTopic> chosen = only_topic(topics, none.remark);
  return chosen ? speeds_of(*chosen) : none;
}

}  // namespace

Result<BagSpeeds> read_bag_speeds(const fs::path& path, const std::string& topic) {
  Result<BagSpeeds> speeds = read_speeds(path, topic);
  if (speeds) {
    for (std::string& warning : speeds->warnings) warning.insert(0, path.string() + ": ");
    return speeds;
  }
  if (!topic.empty()) {
    Error error = speeds.error();
    if (error.file.empty()) error.file = path.string();
    return error;
  }
  // They are optional, and the scans can still be read.
  BagSpeeds none;
  none.warnings.push_back("wheel speeds are not used: " + to_string(speeds.error()));
  return none;
}

}  // namespace sightline
