#include <fmt/format.h>

#include <vector>

#include "formats/foreign/clouds/read_point_cloud.h"
#include "passes/ingest/ingest.h"

namespace sightline {

std::vector<OptionField> option_fields(IngestOptions& options) {
  return {shared(number("tile_m", options.tile_m, "edge length of a map tile, m", 1.0, 4096.0))};
}

std::vector<OptionField> option_fields(RecordingOptions& options) {
  return {
      text("name", options.name, "name of the drive; empty: the name of the folder"),
      text("scans", options.scans,
           fmt::format("folder with one file per scan ({}); or a bag of ROS 1 (.bag) or ROS 2 "
                       "(.db3, .mcap, folder), or a pcap of a Velodyne, Hesai or Ouster sensor",
                       scan_endings_text())),
      text("topic", options.topic,
           "topic of the scans in a bag (PointCloud2, Livox CustomMsg, VelodyneScan); empty: the "
           "only one"),
      text("columns", options.columns,
           "columns of .bin scans: the number of floats per point, or names such as x y z "
           "intensity ring time; empty: guessed from the values"),
      text("poses", options.poses,
           "pose file (KITTI, TUM, Apollo, nuScenes' ego_pose.json; in degrees: GNSS CSV, NMEA, "
           "KITTI's oxts) or ROS bag; "
           "empty: the trajectory is estimated"),
      text("poses_topic", options.poses_topic,
           "topic of the poses, odometry, /tf or NavSatFix in a bag; empty: the only one"),
      text("imu_topic", options.imu_topic,
           "topic of the inertial unit (sensor_msgs/Imu) in the bag of the scans, for rotation "
           "during a scan and for the speed where scans do not constrain it; empty: the one with a "
           "known frame; none: not used"),
      text("wheel_speed", options.wheel_speed,
           "topic of the vehicle's speed (TwistStamped, TwistWithCovarianceStamped, Autoware's "
           "VelocityReport, twist of Odometry) in the bag of the scans, used where scans do not "
           "constrain the speed; empty: the only one; none: not used"),
      choice("pose_format", options.pose_format, "format of a pose file",
             {"auto", "kitti", "tum", "apollo"}),
      choice("poses_of", options.poses_of, "frame of the poses: the vehicle or the sensor",
             {"vehicle", "sensor"}),
      text("calibration", options.calibration,
           "KITTI's calib.txt or calib_imu_to_velo.txt, for poses of the camera or the inertial "
           "unit; empty: none"),
      text("stamps", options.stamps,
           "file with one time per line, one for each scan; empty: times from file names or poses"),
      number("rate_hz", options.rate_hz, "scans per second, used where scan times are unknown",
             0.01, 1000.0),
      text("sensor", options.sensor,
           fmt::format("sensor: {}, or a file that lists its beams",
                       fmt::join(sensor_profile_names(), ", "))),
      integer("rings", options.rings,
              "number of evenly spaced beams; 0: as in the sensor's profile", 0, 1024),
      number("lowest_beam_deg", options.lowest_beam_deg, "elevation of the lowest beam, degrees",
             -90.0, 90.0),
      number("highest_beam_deg", options.highest_beam_deg, "elevation of the highest beam, degrees",
             -90.0, 90.0),
      number("azimuth_view_deg", options.azimuth_view_deg,
             "horizontal field of view, centred on the sensor's x axis, degrees; 0: as in the "
             "sensor's profile",
             0.0, 360.0),
      number("height_m", options.height_m,
             "height of the sensor above the ground, m; 0: as in the sensor's profile", 0.0, 100.0),
      number("lidar_x_m", options.lidar_x_m, "position of the sensor in the vehicle frame, x, m",
             -100.0, 100.0),
      number("lidar_y_m", options.lidar_y_m, "position of the sensor in the vehicle frame, y, m",
             -100.0, 100.0),
      number("lidar_z_m", options.lidar_z_m, "position of the sensor in the vehicle frame, z, m",
             -100.0, 100.0),
      number("lidar_roll_deg", options.lidar_roll_deg,
             "rotation of the sensor about the vehicle's x axis, degrees", -180.0, 180.0),
      number("lidar_pitch_deg", options.lidar_pitch_deg,
             "rotation of the sensor about the vehicle's y axis, degrees", -180.0, 180.0),
      number("lidar_yaw_deg", options.lidar_yaw_deg,
             "rotation of the sensor about the vehicle's z axis, degrees", -180.0, 180.0),
  };
}

}  // namespace sightline
