#pragma once

#include <cmath>

#include "formats/foreign/ros/ros_bag.h"
#include "tests/fuzz/fuzz.h"
#include "tests/support/test_files.h"

// What must hold of a bag, whatever its bytes: its topics, its poses and every scan of it.

namespace sightline {

inline void check_bag_error(const Error& error) {
  check_refusal(error, {ErrorCode::kUnknownName, ErrorCode::kBadValue});
  SIGHTLINE_CHECK(!error.file.empty());
}

// Of a file with an index of its own, which may lead elsewhere than a walk through it, a scan that
// was listed may not be found again.
inline void check_scans(const ScanContainer& container, bool may_miss) {
  for (std::size_t i = 0; i < container.scans().size(); ++i) {
    const Result<std::vector<std::byte>> bytes = container.read(i);
    SIGHTLINE_CHECK(bytes.has_value() || may_miss);
    if (!bytes) {
      check_bag_error(bytes.error());
      continue;
    }
    SIGHTLINE_CHECK(sha256(*bytes) == container.scans()[i].content);
    const Result<PointCloudFile> cloud = container.parse(*bytes, i);
    if (!cloud) {
      check_bag_error(cloud.error());
      continue;
    }
    for (const Eigen::Vector3d& point_m : cloud->points_m) SIGHTLINE_CHECK(point_m.allFinite());
  }
}

// Stamps ascend, or they cannot be interpolated between.
inline void check_poses(const std::vector<PoseRow>& rows) {
  for (std::size_t i = 1; i < rows.size(); ++i) {
    SIGHTLINE_CHECK(*rows[i - 1].stamp_ns < *rows[i].stamp_ns);
  }
}

constexpr const char* kFrameOfSeeds = "lid";

inline void check_turns(const MemoryFile& file, const std::string& topic) {
  const Result<BagTurns> turns = read_bag_turns(file.path(), topic, kFrameOfSeeds);
  if (!turns) {
    check_bag_error(turns.error());
    return;
  }
  for (std::size_t i = 0; i < turns->of_sensor.size(); ++i) {
    const TurnRate& rate = turns->of_sensor[i];
    SIGHTLINE_CHECK(rate.rate_rad_per_s.allFinite());
    SIGHTLINE_CHECK(i == 0 || turns->of_sensor[i - 1].stamp_ns < rate.stamp_ns);
  }
}

inline void check_speeds(const MemoryFile& file, const std::string& topic) {
  const Result<BagSpeeds> speeds = read_bag_speeds(file.path(), topic);
  if (!speeds) {
    check_bag_error(speeds.error());
    return;
  }
  for (std::size_t i = 0; i < speeds->speeds.size(); ++i) {
    const WheelSpeed& speed = speeds->speeds[i];
    SIGHTLINE_CHECK(std::isfinite(speed.speed_m_s));
    SIGHTLINE_CHECK(i == 0 || speeds->speeds[i - 1].stamp_ns < speed.stamp_ns);
  }
}

inline void check_bag(std::span<const std::byte> bytes, bool may_miss = false) {
  const MemoryFile file(bytes);
  const Result<std::vector<BagTopic>> topics = list_bag_topics(file.path());
  if (!topics) {
    check_bag_error(topics.error());
    return;
  }
  check_turns(file, "");
  check_speeds(file, "");
  constexpr std::size_t kMostTopics = 8;  // each is read from the beginning
  for (std::size_t i = 0; i < std::min(topics->size(), kMostTopics); ++i) {
    const std::string& name = (*topics)[i].name;
    const Result<std::optional<GeodeticTrack>> fixes = read_bag_fixes(file.path(), name);
    if (!fixes) check_bag_error(fixes.error());
    const Result<std::vector<PoseRow>> rows = read_bag_poses(file.path(), name);
    if (rows) {
      check_poses(*rows);
    } else {
      check_bag_error(rows.error());
    }
    check_turns(file, name);
    check_speeds(file, name);
    const auto scans = open_bag(file.path(), name);
    if (scans) {
      check_scans(**scans, may_miss);
    } else {
      check_bag_error(scans.error());
    }
  }
}

}  // namespace sightline
