#pragma once

#include <random>
#include <string>
#include <vector>

#include "formats/foreign/ros/scan_messages.h"
#include "tests/formats/foreign/bag_files.h"

namespace sightline {

inline constexpr std::uint32_t kBagFirst_s = 1'567'410'201;

inline std::string small_cloud(std::uint32_t seconds, std::uint32_t nanoseconds, float x_m,
                               std::uint32_t points = 2) {
  std::string data;
  for (std::uint32_t i = 0; i < points; ++i) {
    data += as_bytes({x_m + static_cast<float>(i), 2.0F, 3.0F, 9.0F}) + as_bytes({1000 * i});
  }
  const std::vector<BagField> fields = {
      {"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}, {"intensity", 12, 7}, {"t", 16, 6}};
  return cloud_message(seconds, nanoseconds, fields, points, 20, data);
}

inline std::string small_odometry(std::uint32_t seconds, std::uint32_t nanoseconds, double x_m) {
  return ros_header(seconds, nanoseconds) + ros_text("base_link") +
         as_bytes({x_m, 2.0, 3.0, 0.0, 0.0, 1.0, 0.0}) +
         std::string(36 * 8 + 12 * 8 + 36 * 8, '\0');
}

inline std::uint32_t random_below(std::mt19937& random, std::uint32_t end) {
  return static_cast<std::uint32_t>(random() % end);
}

inline std::vector<BagMessage> random_messages(std::mt19937& random, std::uint32_t count) {
  std::vector<BagMessage> messages;
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t now_ns = 10'000'000 * i + random_below(random, 30'000'000);
    const auto x_m = static_cast<float>(i + 1);
    BagMessage message{"/noise", "std_msgs/String", kBagFirst_s, now_ns, ""};
    message.bytes = std::string(random() % 300, 'n');
    if (random() % 3 == 0) {
      message.topic = "/points";
      message.type = kPointCloud2;
      message.bytes = small_cloud(kBagFirst_s, now_ns, x_m, 1 + random_below(random, 9));
    } else if (random() % 2 == 0) {
      message.topic = "/odom";
      message.type = "nav_msgs/Odometry";
      message.bytes = small_odometry(kBagFirst_s, 10'000'000 * i, x_m);
    }
    messages.push_back(std::move(message));
  }
  return messages;
}

}  // namespace sightline
