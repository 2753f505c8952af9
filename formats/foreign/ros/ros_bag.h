#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "formats/foreign/logs/scan_container.h"
#include "formats/foreign/text/geodetic_track.h"
#include "formats/foreign/text/pose_file.h"

namespace sightline {

// A bag: a recording of ROS 1 or ROS 2, see open_message_log.

// Whether a path is one.
bool is_ros_bag(const std::filesystem::path& path);

struct BagTopic {
  std::string name;
  std::string type;  // "sensor_msgs/PointCloud2"
  std::size_t message_count = 0;
};

// What a bag holds, by name. Errors: those of open_message_log.
Result<std::vector<BagTopic>> list_bag_topics(const std::filesystem::path& path);

// The poses of one topic of a bag (see is_pose_message; empty: the only such topic), in order of
// their stamps. A topic of transforms (/tf), where named or the only one, gives those of `frame`
// (empty: base_link, else base_footprint), see TransformTree. Errors: those of open_message_log,
// TransformTree and parse_pose_message; unknown-name, bad-value, time-runs-backwards.
// `world_frame` becomes the frame that they are in.
Result<std::vector<PoseRow>> read_bag_poses(const std::filesystem::path& path,
                                            const std::string& topic, const std::string& frame = "",
                                            std::string* world_frame = nullptr);

// The places of one topic of NavSatFix, in order of their stamps: of the one named, or, where the
// name is empty and there are neither poses nor transforms, of the only one. Nothing where another
// topic is meant. Errors: those of open_message_log and parse_fix_message.
Result<std::optional<GeodeticTrack>> read_bag_fixes(const std::filesystem::path& path,
                                                    const std::string& topic);

// T_vehicle_sensor, where transforms of a bag tell it and it does not move; the vehicle as above.
// Errors: those of open_message_log and parse_transforms.
Result<std::optional<Pose>> bag_mounting(const std::filesystem::path& path,
                                         const std::string& sensor_frame);

// The scans of one topic (see is_scan_message) of a bag; errors of open_scan_container.
Result<std::shared_ptr<const ScanContainer>> open_bag(const std::filesystem::path& path,
                                                      const std::string& topic);

// What an inertial unit beside the sensor of a bag's scans measured, about the axes of the sensor's
// frame; ascending in time.
struct BagTurns {
  std::string topic;  // whose they are; empty: there are none
  std::vector<TurnRate> of_sensor;
  std::vector<SpecificForce> forces_of_sensor;  // of the messages that have one
  std::vector<std::string> warnings;            // which topic it is, what is left out, and why
};

// The angular velocities and specific forces of one topic of sensor_msgs/Imu, by stamp (of the
// recording where zero), each time once: of the one named, or, where the name is empty, of the one
// with the most messages whose frame is fixed to that of the scans; a warning where there is none.
// Messages that are short, not finite, without angular velocity or faster than 100 rad/s are
// counted in a warning. Errors, where a topic is named, else warnings: unknown-name, and those of
// open_message_log and parse_transforms.
Result<BagTurns> read_bag_turns(const std::filesystem::path& path, const std::string& topic,
                                const std::string& sensor_frame);

// Speeds of the vehicle along its x axis, as the messages of one topic contain them.
struct BagSpeeds {
  std::string topic;                  // whose they are; empty: there are none
  std::string type;                   // of the topic
  std::vector<WheelSpeed> speeds;     // ascending in time
  std::vector<std::string> warnings;  // what is left out, and why
  std::string remark;                 // why no topic was chosen among several; else empty
};

// The speeds of one topic (see is_speed_message), by stamp (of the recording where zero), each time
// once: of the one named, or, where the name is empty, of the only one with speeds other than zero;
// topics of nav_msgs/Odometry only where no other topic has any, since many leave the twist empty.
// Messages that are short or not finite are skipped, and those out of order are sorted, up to 5 %
// of either, with a warning. Errors, where a topic is named, else warnings: unknown-name, bad-value
// (more messages without a speed; place: the first), time-runs-backwards (more out of order; place:
// the first), and those of open_message_log.
Result<BagSpeeds> read_bag_speeds(const std::filesystem::path& path, const std::string& topic);

}  // namespace sightline
