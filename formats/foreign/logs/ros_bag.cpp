#include "formats/foreign/logs/ros_bag.h"

#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <utility>

#include "formats/foreign/logs/ros_messages.h"

// All that knows librosbag-storage.

namespace sightline {
namespace {

Error error_of(const std::filesystem::path& path, ErrorCode code, std::string message) {
  return {code, std::move(message), path.string(), ""};
}

// Runs what calls the library, and says in our words what it threw.
template <class T>
Result<T> guarded(const std::filesystem::path& path, const std::function<Result<T>()>& body) {
  try {
    return body();
  } catch (const rosbag::BagUnindexedException&) {
    return error_of(path, ErrorCode::kMalformedHeader,
                    "the bag has no index, it was not closed; run `rosbag reindex` on it");
  } catch (const rosbag::BagException& exception) {
    return error_of(path, ErrorCode::kMalformedHeader,
                    std::string("not a bag that can be read: ") + exception.what());
  } catch (const std::exception& exception) {
    return error_of(path, ErrorCode::kCannotRead, exception.what());
  }
}

// The topic to read: the one that is named, or the only one of a type that is wanted.
Result<std::string> choose_topic(const std::filesystem::path& path, rosbag::View& view,
                                 const std::string& wanted,
                                 const std::function<bool(std::string_view)>& is_type) {
  std::set<std::string> fitting;
  std::string all;
  for (const rosbag::ConnectionInfo* connection : view.getConnections()) {
    if (is_type(connection->datatype)) fitting.insert(connection->topic);
    all += " " + connection->topic + " (" + connection->datatype + ")";
  }
  if (fitting.contains(wanted)) return wanted;
  if (!wanted.empty()) {
    return error_of(path, ErrorCode::kUnknownName,
                    "no topic '" + wanted + "' of a type that is read here; the bag has:" + all);
  }
  if (fitting.size() == 1) return *fitting.begin();
  if (fitting.empty()) {
    return error_of(path, ErrorCode::kUnsupportedFormat,
                    "no topic of a type that is read here; the bag has:" + all +
                        "; packets must be turned into sensor_msgs/PointCloud2 first");
  }
  return error_of(path, ErrorCode::kBadValue,
                  "several topics to choose from, name one of them; the bag has:" + all);
}

std::vector<std::byte> bytes_of(const rosbag::MessageInstance& message) {
  std::vector<std::byte> bytes(message.size());
  ros::serialization::OStream stream(reinterpret_cast<std::uint8_t*>(bytes.data()),
                                     static_cast<std::uint32_t>(bytes.size()));
  message.write(stream);
  return bytes;
}

// A header's stamp, or the time of its recording where the driver left it at zero.
Result<std::int64_t> stamp_of(const rosbag::MessageInstance& message,
                              const std::vector<std::byte>& bytes, const std::string& file) {
  const Result<std::int64_t> stamp_ns = header_stamp_ns(bytes, file);
  if (!stamp_ns || *stamp_ns != 0) return stamp_ns;
  return static_cast<std::int64_t>(message.getTime().toNSec());
}

class BagScans : public ScanContainer {
 public:
  explicit BagScans(std::filesystem::path path) : path_(std::move(path)) {}

  Result<void> build_index(const std::string& topic);
  Result<std::vector<std::byte>> read(std::size_t index) const override;
  Result<PointCloudFile> parse(std::span<const std::byte> bytes, std::size_t index) const override {
    return parse_point_cloud2(bytes, path_.string() + "#" + std::to_string(index));
  }

 private:
  std::filesystem::path path_;
  rosbag::Bag bag_;
  // Where the messages lie. A copy of an instance stays good as long as the bag is open.
  std::vector<rosbag::MessageInstance> messages_;
  // The library reads through one file and one buffer.
  mutable std::mutex mutex_;
};

Result<void> BagScans::build_index(const std::string& topic) {
  bag_.open(path_.string(), rosbag::bagmode::Read);
  rosbag::View everything(bag_);
  const Result<std::string> chosen = choose_topic(
      path_, everything, topic, [](std::string_view type) { return type == kPointCloud2; });
  if (!chosen) return chosen.error();
  rosbag::View view(bag_, rosbag::TopicQuery(*chosen));
  for (const rosbag::MessageInstance& message : view) {
    const std::vector<std::byte> bytes = bytes_of(message);
    const std::string name = path_.string() + "#" + std::to_string(messages_.size());
    SIGHTLINE_ASSIGN(const std::int64_t stamp_ns, stamp_of(message, bytes, name));
    scans_.push_back({stamp_ns, sha256(bytes)});
    messages_.push_back(message);
  }
  return {};
}

Result<std::vector<std::byte>> BagScans::read(std::size_t index) const {
  const std::scoped_lock lock(mutex_);
  return guarded<std::vector<std::byte>>(
      path_, [&]() -> Result<std::vector<std::byte>> { return bytes_of(messages_.at(index)); });
}

Result<std::vector<PoseRow>> poses_of(const std::filesystem::path& path, const std::string& topic) {
  rosbag::Bag bag(path.string(), rosbag::bagmode::Read);
  rosbag::View everything(bag);
  SIGHTLINE_ASSIGN(const std::string chosen,
                   choose_topic(path, everything, topic, &is_pose_message));
  std::vector<PoseRow> rows;
  rosbag::View view(bag, rosbag::TopicQuery(chosen));
  for (const rosbag::MessageInstance& message : view) {
    SIGHTLINE_ASSIGN(PoseRow row,
                     parse_pose_message(bytes_of(message), message.getDataType(), path.string()));
    if (!rows.empty() && *row.stamp_ns == *rows.back().stamp_ns) continue;  // said twice
    if (!rows.empty() && *row.stamp_ns < *rows.back().stamp_ns) {
      return Error{ErrorCode::kTimeRunsBackwards,
                   "found time " + format_stamp(*row.stamp_ns) + " s after " +
                       format_stamp(*rows.back().stamp_ns) + " s",
                   path.string(), chosen + " message " + std::to_string(rows.size())};
    }
    rows.push_back(row);
  }
  return rows;
}

std::vector<BagTopic> topics_of(const std::filesystem::path& path) {
  rosbag::Bag bag(path.string(), rosbag::bagmode::Read);
  rosbag::View everything(bag);
  std::map<std::string, BagTopic> topics;
  for (const rosbag::ConnectionInfo* connection : everything.getConnections()) {
    topics[connection->topic] = {connection->topic, connection->datatype, 0};
  }
  std::vector<BagTopic> listed;
  for (auto& [name, topic] : topics) {
    topic.message_count = rosbag::View(bag, rosbag::TopicQuery(name)).size();
    listed.push_back(std::move(topic));
  }
  return listed;
}

}  // namespace

Result<std::vector<BagTopic>> list_bag_topics(const std::filesystem::path& path) {
  using Topics = std::vector<BagTopic>;
  return guarded<Topics>(path, [&]() -> Result<Topics> { return topics_of(path); });
}

bool is_ros_bag(const std::filesystem::path& path) {
  constexpr std::string_view kSignature = "#ROSBAG";
  std::string bytes(kSignature.size(), '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return bytes == kSignature;
}

Result<std::vector<PoseRow>> read_bag_poses(const std::filesystem::path& path,
                                            const std::string& topic) {
  return guarded<std::vector<PoseRow>>(path, [&] { return poses_of(path, topic); });
}

Result<std::shared_ptr<const ScanContainer>> open_bag(const std::filesystem::path& path,
                                                      const std::string& topic) {
  using Opened = std::shared_ptr<const ScanContainer>;
  return guarded<Opened>(path, [&]() -> Result<Opened> {
    auto scans = std::make_shared<BagScans>(path);
    SIGHTLINE_TRY(scans->build_index(topic));
    return Opened(std::move(scans));
  });
}

}  // namespace sightline
