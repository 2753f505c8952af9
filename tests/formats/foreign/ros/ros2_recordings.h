#pragma once

#include <string>

#include "formats/foreign/ros/ros_messages.h"
#include "tests/formats/foreign/bag_files.h"

namespace sightline {

inline constexpr std::uint32_t kFirst_s = 1'567'410'201;

inline std::string recording_path(const std::string& name) {
  return std::string(SIGHTLINE_RECORDINGS) + "/" + name;
}

}  // namespace sightline
