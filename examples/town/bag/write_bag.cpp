#include "examples/town/bag/write_bag.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "examples/town/bag/imu.h"
#include "formats/base/parallel.h"
#include "formats/base/units.h"

// MCAP (mcap.dev/spec): records of a letter, a length and their content.

namespace sightline::town {
namespace {

constexpr std::int64_t kStart_ns = 1'757'000'000 * kSecond_ns;

template <class T>
void put(std::string& bytes, T value) {
  std::array<char, sizeof(T)> raw{};
  std::memcpy(raw.data(), &value, sizeof(T));
  bytes.append(raw.data(), raw.size());
}

void put_text(std::string& bytes, std::string_view text) {
  put(bytes, static_cast<std::uint32_t>(text.size()));
  bytes.append(text);
}

std::string record(char letter, const std::string& content) {
  std::string bytes(1, letter);
  put(bytes, static_cast<std::uint64_t>(content.size()));
  return bytes + content;
}

// ---- Messages of ROS 1.

struct Topic {
  std::string_view name;
  std::string_view type;
};
// The last one is in the bags of hard worlds only.
enum Channel : std::uint16_t { kPoints, kOdometry, kImu, kTransforms, kWheels };
constexpr std::array<Topic, 5> kTopics = {{{"/points", "sensor_msgs/PointCloud2"},
                                           {"/odom", "nav_msgs/Odometry"},
                                           {"/imu", "sensor_msgs/Imu"},
                                           {"/tf_static", "tf2_msgs/TFMessage"},
                                           {"/wheel_speed", "geometry_msgs/TwistStamped"}}};

std::string header(std::int64_t stamp_ns, std::string_view frame) {
  const std::int64_t time_ns = kStart_ns + stamp_ns;
  std::string bytes;
  put(bytes, std::uint32_t{0});
  put(bytes, static_cast<std::uint32_t>(time_ns / kSecond_ns));
  put(bytes, static_cast<std::uint32_t>(time_ns % kSecond_ns));
  put_text(bytes, frame);
  return bytes;
}

void put_pose(std::string& bytes, const Pose& pose) {
  const Eigen::Quaterniond q(pose.linear());
  for (int axis = 0; axis < 3; ++axis) put(bytes, pose.translation()[axis]);
  for (const double number : {q.x(), q.y(), q.z(), q.w()}) put(bytes, number);
}

void put_zeros(std::string& bytes, std::size_t numbers) {
  bytes.append(numbers * sizeof(double), '\0');
}

std::string points_message(const TownScan& scan) {
  constexpr std::array<std::string_view, 5> kFields = {"x", "y", "z", "intensity", "t"};
  constexpr std::uint32_t kPointSize = 20;
  constexpr char kFloat32 = 7;
  constexpr char kUint32 = 6;
  const auto count = static_cast<std::uint32_t>(scan.points.size());
  std::string bytes = header(scan.stamp_ns, "lidar");
  for (const std::uint32_t number : {1U, count, static_cast<std::uint32_t>(kFields.size())}) {
    put(bytes, number);
  }
  for (std::uint32_t i = 0; i < kFields.size(); ++i) {
    put_text(bytes, kFields[i]);
    put(bytes, 4 * i);
    put(bytes, kFields[i] == "t" ? kUint32 : kFloat32);
    put(bytes, std::uint32_t{1});
  }
  put(bytes, '\0');  // little-endian
  for (const std::uint32_t number : {kPointSize, kPointSize * count, kPointSize * count}) {
    put(bytes, number);
  }
  for (std::size_t i = 0; i < scan.points.size(); ++i) {
    const LabelledPoint& point = scan.points[i];
    for (int axis = 0; axis < 3; ++axis) put(bytes, point.position_m[axis]);
    put(bytes, point.intensity);
    put(bytes, static_cast<std::uint32_t>(scan.time_offset_ns[i]));
  }
  put(bytes, '\1');  // dense
  return bytes;
}

std::string odometry_message(std::int64_t stamp_ns, const Pose& T_world_vehicle) {
  constexpr std::size_t kCovariance = 36;
  std::string bytes = header(stamp_ns, "map");
  put_text(bytes, "base_link");
  put_pose(bytes, T_world_vehicle);
  put_zeros(bytes, kCovariance + 6 + kCovariance);
  return bytes;
}

// Without a force the unit measures turns only.
std::string imu_message(const TurnRate& rate, const Eigen::Vector3d* force_m_s2) {
  const Eigen::Vector3d of_imu = T_vehicle_imu().linear().transpose() * rate.rate_rad_per_s;
  std::string bytes = header(rate.stamp_ns, "imu");
  put_zeros(bytes, 4);
  put(bytes, -1.0);  // no orientation
  put_zeros(bytes, 8);
  for (int axis = 0; axis < 3; ++axis) put(bytes, of_imu[axis]);
  put_zeros(bytes, 9);
  if (force_m_s2 == nullptr) {
    put_zeros(bytes, 3);
  } else {
    for (int axis = 0; axis < 3; ++axis) put(bytes, (*force_m_s2)[axis]);
  }
  put_zeros(bytes, 9);
  return bytes;
}

std::string wheels_message(const WheelSpeed& speed) {
  std::string bytes = header(speed.stamp_ns, "base_link");
  put(bytes, speed.speed_m_s);
  put_zeros(bytes, 4);
  put(bytes, speed.yaw_rate_rad_s);
  return bytes;
}

std::string mountings_message(const SensorProfile& sensor) {
  std::string bytes;
  put(bytes, std::uint32_t{2});
  const auto add = [&](std::string_view child, const Pose& T_vehicle_child) {
    bytes += header(0, "base_link");
    put_text(bytes, child);
    put_pose(bytes, T_vehicle_child);
  };
  add("lidar", sensor.T_vehicle_lidar);
  add("imu", T_vehicle_imu());
  return bytes;
}

// ---- The file.

class BagFile {
 public:
  BagFile(const std::filesystem::path& path, std::size_t topics) : file_(path, std::ios::binary) {
    file_ << kMagic;
    std::string content;
    put_text(content, "ros1");
    put_text(content, "sightline_town");
    file_ << record(1, content);
    for (std::size_t i = 0; i < topics; ++i) describe(i);
  }

  void add(Channel channel, std::int64_t stamp_ns, const std::string& message) {
    std::string content;
    put(content, static_cast<std::uint16_t>(channel));
    put(content, sequence_++);
    put(content, kStart_ns + stamp_ns);  // of the recording
    put(content, kStart_ns + stamp_ns);  // of the sending
    file_ << record(5, content + message);
  }

  bool close() {
    file_ << record(15, std::string(4, '\0')) << record(2, std::string(20, '\0')) << kMagic;
    file_.close();
    return file_.good();
  }

 private:
  static constexpr std::string_view kMagic = "\x89MCAP0\r\n";

  void describe(std::size_t i) {
    const auto channel = static_cast<std::uint16_t>(i);
    const auto schema = static_cast<std::uint16_t>(i + 1);
    std::string content;
    put(content, schema);
    put_text(content, kTopics.at(i).type);
    put_text(content, "ros1msg");
    put_text(content, "");
    file_ << record(3, content);
    content.clear();
    put(content, channel);
    put(content, schema);
    put_text(content, kTopics.at(i).name);
    put_text(content, "ros1");
    put_text(content, "");
    file_ << record(4, content);
  }

  std::ofstream file_;
  std::uint32_t sequence_ = 0;
};

// What sensors beside the LiDAR measure during a drive, written in order of time.
class OtherSensors {
 public:
  OtherSensors(const DriveSimulator& drive, const BagOptions& options)
      : rates_(imu_of(drive, options.seed)) {
    if (!options.has_motion) return;
    forces_ = specific_forces(drive, options.seed, rates_);
    speeds_ = wheel_speeds(drive, options.seed);
  }
  [[nodiscard]] std::int64_t first_ns() const { return rates_.front().stamp_ns; }
  [[nodiscard]] std::int64_t last_ns() const { return rates_.back().stamp_ns; }

  void write_before(std::int64_t stamp_ns, BagFile& file) {
    for (; next_rate_ < rates_.size() && rates_[next_rate_].stamp_ns < stamp_ns; ++next_rate_) {
      const TurnRate& rate = rates_[next_rate_];
      write_speeds_before(rate.stamp_ns, file);
      const Eigen::Vector3d* force = forces_.empty() ? nullptr : &forces_[next_rate_];
      file.add(kImu, rate.stamp_ns, imu_message(rate, force));
    }
    write_speeds_before(stamp_ns, file);
  }

 private:
  void write_speeds_before(std::int64_t stamp_ns, BagFile& file) {
    for (; next_speed_ < speeds_.size() && speeds_[next_speed_].stamp_ns < stamp_ns;
         ++next_speed_) {
      file.add(kWheels, speeds_[next_speed_].stamp_ns, wheels_message(speeds_[next_speed_]));
    }
  }

  std::vector<TurnRate> rates_;
  std::vector<Eigen::Vector3d> forces_;
  std::vector<WheelSpeed> speeds_;
  std::size_t next_rate_ = 0;
  std::size_t next_speed_ = 0;
};

}  // namespace

Result<void> write_bag(const std::filesystem::path& path, const DriveSimulator& drive,
                       std::span<const Pose> poses, const BagOptions& options) {
  constexpr std::size_t kBatch = 32;  // scans in memory
  std::error_code ignored;
  std::filesystem::create_directories(path.parent_path(), ignored);
  BagFile file(path, options.has_motion ? kTopics.size() : kTopics.size() - 1);
  OtherSensors others(drive, options);
  file.add(kTransforms, others.first_ns(), mountings_message(drive.sensor()));
  for (std::size_t first = 0; first < drive.scan_count(); first += kBatch) {
    const std::size_t count = std::min(kBatch, drive.scan_count() - first);
    const std::vector<TownScan> scans = parallel_map<TownScan>(
        count, options.threads, [&](std::size_t i) { return drive.scan(first + i); });
    for (std::size_t i = 0; i < count; ++i) {
      others.write_before(scans[i].stamp_ns, file);
      Pose T_world_vehicle = poses[first + i];
      T_world_vehicle.translation().head<2>() += options.origin_world_m;
      file.add(kOdometry, scans[i].stamp_ns, odometry_message(scans[i].stamp_ns, T_world_vehicle));
      file.add(kPoints, scans[i].stamp_ns, points_message(scans[i]));
    }
  }
  others.write_before(others.last_ns() + 1, file);
  if (file.close()) return {};
  return Error{ErrorCode::kCannotWrite, "the bag could not be written whole", path.string()};
}

}  // namespace sightline::town
