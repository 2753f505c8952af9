#include "formats/foreign/ros/message_writer.h"

#include <type_traits>

#include "formats/base/units.h"

namespace sightline {
namespace {

// Fields of CDR, little-endian: each number is at a multiple of its size behind the four bytes that
// name the encoding; a text and a sequence begin with their length.
class CdrWriter {
 public:
  CdrWriter() { bytes_.put<std::uint32_t>(0x0000'0100); }  // 00 01 00 00: CDR, little-endian

  template <class T>
  requires std::is_arithmetic_v<T>
  void put(T value) {
    while ((bytes_.count() - kBegin) % sizeof(T) != 0) bytes_.put<std::uint8_t>(0);
    bytes_.put(value);
  }
  void text(std::string_view text) {
    put(static_cast<std::uint32_t>(text.size() + 1));
    bytes_.append(text.data(), text.size());
    bytes_.put<std::uint8_t>(0);
  }
  void time(std::int64_t time_ns) {
    std::int64_t seconds = time_ns / kSecond_ns;
    if (time_ns % kSecond_ns < 0) --seconds;
    put(static_cast<std::int32_t>(seconds));
    put(static_cast<std::uint32_t>(time_ns - seconds * kSecond_ns));
  }
  void header(std::int64_t stamp_ns, std::string_view frame) {
    time(stamp_ns);
    text(frame);
  }
  void pose(const Pose& pose) {
    for (int axis = 0; axis < 3; ++axis) put(pose.translation()[axis]);
    const Eigen::Quaterniond turn = quaternion_of(pose);
    for (const double number : {turn.x(), turn.y(), turn.z(), turn.w()}) put(number);
  }
  std::vector<std::byte> take() { return bytes_.take(); }

 private:
  static constexpr std::size_t kBegin = 4;
  static Eigen::Quaterniond quaternion_of(const Pose& pose) {
    Eigen::Quaterniond turn(pose.linear());
    turn.normalize();
    if (turn.w() < 0.0) turn.coeffs() = -turn.coeffs();
    return turn;
  }
  ByteWriter bytes_;
};

#define SIGHTLINE_MSG_BREAK \
  "================================================================================\nMSG: "
#define SIGHTLINE_MSG_HEADER                                                              \
  SIGHTLINE_MSG_BREAK                                                                     \
  "std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n" SIGHTLINE_MSG_BREAK \
  "builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
#define SIGHTLINE_MSG_POSE                                                           \
  SIGHTLINE_MSG_BREAK                                                                \
  "geometry_msgs/Pose\nPoint position\nQuaternion orientation\n" SIGHTLINE_MSG_BREAK \
  "geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n" SIGHTLINE_MSG_BREAK       \
  "geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"

}  // namespace

const McapType kPoseWithCovarianceStamped = {
    "geometry_msgs/msg/PoseWithCovarianceStamped",
    "std_msgs/Header header\nPoseWithCovariance pose\n" SIGHTLINE_MSG_BREAK
    "geometry_msgs/PoseWithCovariance\nPose pose\nfloat64[36] covariance\n" SIGHTLINE_MSG_POSE
        SIGHTLINE_MSG_HEADER};

const McapType kPath = {
    "nav_msgs/msg/Path",
    "std_msgs/Header header\ngeometry_msgs/PoseStamped[] poses\n" SIGHTLINE_MSG_BREAK
    "geometry_msgs/PoseStamped\nstd_msgs/Header header\nPose pose\n" SIGHTLINE_MSG_POSE
        SIGHTLINE_MSG_HEADER};

const McapType kDiagnosticArray = {
    "diagnostic_msgs/msg/DiagnosticArray",
    "std_msgs/Header header\nDiagnosticStatus[] status\n" SIGHTLINE_MSG_BREAK
    "diagnostic_msgs/DiagnosticStatus\nbyte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\n"
    "byte level\nstring name\nstring message\nstring hardware_id\nKeyValue[] "
    "values\n" SIGHTLINE_MSG_BREAK
    "diagnostic_msgs/KeyValue\nstring key\nstring value\n" SIGHTLINE_MSG_HEADER};

std::vector<std::byte> pose_message(std::int64_t stamp_ns, std::string_view frame,
                                    const Pose& T_frame_vehicle, const Covariance& covariance) {
  CdrWriter message;
  message.header(stamp_ns, frame);
  message.pose(T_frame_vehicle);
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 6; ++column) message.put(covariance(row, column));
  }
  return message.take();
}

std::vector<std::byte> path_message(std::string_view frame, std::span<const StampedPose> poses) {
  CdrWriter message;
  message.header(poses.empty() ? 0 : poses.front().stamp_ns, frame);
  message.put(static_cast<std::uint32_t>(poses.size()));
  for (const StampedPose& pose : poses) {
    message.header(pose.stamp_ns, frame);
    message.pose(pose.T_frame_vehicle);
  }
  return message.take();
}

std::vector<std::byte> status_message(std::int64_t stamp_ns, std::string_view frame,
                                      const Status& status) {
  CdrWriter message;
  message.header(stamp_ns, frame);
  message.put<std::uint32_t>(1);
  message.put(static_cast<std::uint8_t>(status.level));
  message.text(status.name);
  message.text(status.message);
  message.text(status.hardware);
  message.put(static_cast<std::uint32_t>(status.values.size()));
  for (const auto& [key, value] : status.values) {
    message.text(key);
    message.text(value);
  }
  return message.take();
}

}  // namespace sightline
