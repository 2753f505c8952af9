#pragma once

#include <cstdint>
#include <sstream>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace sightline_ros2 {

enum class Level : unsigned char { kOk = 0, kWarn = 1, kError = 2 };  // of DiagnosticStatus

// One status of /diagnostics, without ROS.
struct Report {
  std::string name;
  Level level = Level::kOk;
  std::string message;
  std::vector<std::pair<std::string, std::string>> values;

  template <class Value>
  void add(const std::string& key, const Value& value) {
    if constexpr (std::is_same_v<Value, bool>) {
      values.emplace_back(key, value ? "True" : "False");
    } else {
      std::ostringstream text;
      text << value;
      values.emplace_back(key, text.str());
    }
  }
  void raise(Level to, const std::string& text) {
    if (to > level) level = to;
    message += (message.empty() ? "" : "; ") + text;
  }
};

inline Report report_named(const std::string& name) {
  Report report;
  report.name = name;
  return report;
}

}  // namespace sightline_ros2
