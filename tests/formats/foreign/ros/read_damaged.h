#pragma once

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

#include "formats/foreign/ros/ros_bag.h"

namespace sightline {

inline void expect_clean(const Error& error, const std::string& path) {
  EXPECT_TRUE(error_class(error.code) == ErrorClass::kInput ||
              error.code == ErrorCode::kUnknownName || error.code == ErrorCode::kBadValue)
      << to_string(error);
  EXPECT_FALSE(error.message.empty());
  EXPECT_EQ(error.file.substr(0, path.size()), path) << to_string(error);
}

// Reads topics, poses, turn rates and scans of a recording that may be damaged, and expects errors
// to be clean. The contents of the scans on "/points"; nothing where they are refused.
inline std::optional<std::vector<Digest>> read_damaged(const std::string& path) {
  const Result<std::vector<BagTopic>> topics = list_bag_topics(path);
  if (!topics) expect_clean(topics.error(), path);
  for (const char* topic : {"", "/tf"}) {
    const Result<std::vector<PoseRow>> poses = read_bag_poses(path, topic);
    if (!poses) expect_clean(poses.error(), path);
  }
  for (const char* topic : {"", "/imu/data"}) {
    const Result<BagTurns> turns = read_bag_turns(path, topic, "lidar");
    if (!turns) expect_clean(turns.error(), path);
  }
  const auto scans = open_bag(path, "/points");
  if (!scans) {
    expect_clean(scans.error(), path);
    return std::nullopt;
  }
  std::vector<Digest> contents;
  for (std::size_t i = 0; i < (*scans)->scans().size(); ++i) {
    const Result<std::vector<std::byte>> bytes = (*scans)->read(i);
    EXPECT_TRUE(bytes.has_value());
    if (!bytes) return std::nullopt;
    contents.push_back((*scans)->scans()[i].content);
    EXPECT_EQ(sha256(*bytes), contents.back());
    const Result<PointCloudFile> cloud = (*scans)->parse(*bytes, i);
    if (!cloud) expect_clean(cloud.error(), path);
  }
  return contents;
}

}  // namespace sightline
