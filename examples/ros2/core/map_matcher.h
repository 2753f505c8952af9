#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "formats/reader/reader.h"
#include "passes/vehicle/vehicle_localizer.h"
#include "poses.h"

namespace sightline_ros2 {

// Points of one scan as a message holds them, in a frame that is fixed to the vehicle.
struct ScanPoints {
  sightline_points points{};  // refers to the message's memory
  PoseRows T_base_points{};
};

struct MatcherOptions {
  std::string map_file;
  double limit_m = 0.10;                                       // one of the map's limits
  double visible_m = std::numeric_limits<double>::infinity();  // how far can be seen now
  std::optional<PoseRows> T_base_sensor;                       // where it is not the map's
  bool holds_whole_map = false;
  double protection_risk = 0.0;  // of protection levels; 0: the library's
};

// A match, in the map's frame of ROS: the world of the recording without the whole 100 km that an
// exported point cloud map leaves out.
struct MapMatch {
  sightline_match match{};
  sightline::MapLook look;   // whose match is the pose
  double probability = 0.0;  // that the look is accurate enough; NaN where a second look followed
  Pose pose;                 // of the vehicle
  Covariance covariance{};   // of this pose, given the start's or of an unknown start
};

// Where a scan was found around a pose that is roughly known.
struct AlignedScan {
  MapMatch best;
  double likelihood = 0.0;            // mean over points of the likelihood of the nearest ND
  double likelihood_elsewhere = 0.0;  // of the best place that is another one
  std::vector<Pose> tried;            // where searches ended
};

// A compiled map, and the localizer that matches in it. One thread at a time.
class MapMatcher {
 public:
  static sightline::Result<MapMatcher> open(const MatcherOptions& options);

  // By the map's plan where the vehicle tracks, else by the look of the place. `start_covariance`
  // is NULL where the start is unknown: the pose is then what the scan alone shows. Errors: those
  // of the reader and of the localizer.
  sightline::Result<MapMatch> match(const ScanPoints& scan, const Pose& T_map_start,
                                    const Covariance* start_covariance, bool is_tracking);

  // Scores points at a pose, by a look.
  sightline::Result<sightline_match> score(const ScanPoints& scan, const Pose& T_map_base,
                                           const sightline::MapLook& look);

  // Searches as far as two standard deviations of the start in the plane, at every heading, from
  // about `start_count` places. None where no search ends in a match.
  sightline::Result<std::optional<AlignedScan>> align(const ScanPoints& scan,
                                                      const StampedPose& start,
                                                      std::size_t start_count);

  // The height of the vehicle at the nearest site of the map's route.
  [[nodiscard]] std::optional<double> height_m(double x_m, double y_m) const;

  [[nodiscard]] const sightline::MapInfo& info() const { return map_.info(); }
  [[nodiscard]] const PoseRows& T_base_sensor() const { return T_base_sensor_; }
  [[nodiscard]] std::vector<sightline::Error> faults() const { return localizer_.faults(); }
  [[nodiscard]] double longest_range_m() const { return map_.info().ranges_m.back(); }

 private:
  MapMatcher(sightline::MapReader map, sightline::VehicleLocalizer localizer,
             const MatcherOptions& options);
  sightline_points in_sensor(const ScanPoints& scan);
  [[nodiscard]] PoseRows world_rows(const Pose& T_map_base) const;
  [[nodiscard]] MapMatch as_match(const sightline_match& match) const;
  sightline::Result<std::vector<MapMatch>> matches_from(const sightline_points& points,
                                                        const std::vector<Pose>& starts,
                                                        const sightline::MapLook& look) const;

  sightline::MapReader map_;
  sightline::VehicleLocalizer localizer_;
  double limit_m_;
  double visible_m_;
  double protection_risk_;
  PoseRows T_base_sensor_;
  std::vector<double> moved_m_;                 // points of a scan in the sensor's frame
  std::vector<std::array<double, 3>> route_m_;  // of the vehicle, in the map's frame
};

double likelihood_of(const sightline_match& match);
bool has_matched(const sightline_match& match);

// Points of a scan, x y z each, moved by a pose.
std::vector<float> moved(const sightline_points& points, const PoseRows& T_to_from);

}  // namespace sightline_ros2
