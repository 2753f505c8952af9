#!/usr/bin/env python3
"""Headers that a node of ROS 2 includes, made for its test: the messages from their definitions, as
rosidl names and lays them out, and of rclcpp the calls that are used, which remember what they did.

usage: ros2_headers.py FOLDER
"""

import pathlib
import re
import sys

# The definitions of common_interfaces and builtin_interfaces, without comments.
MESSAGES = {
    "builtin_interfaces/Time": "int32 sec\nuint32 nanosec",
    "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id",
    "std_msgs/Float64": "float64 data",
    "std_msgs/String": "string data",
    "geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Quaternion": "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1",
    "geometry_msgs/Pose": "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation",
    "geometry_msgs/PoseStamped": "std_msgs/Header header\ngeometry_msgs/Pose pose",
    "diagnostic_msgs/KeyValue": "string key\nstring value",
    "diagnostic_msgs/DiagnosticStatus": "byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\n"
    "byte level\nstring name\nstring message\nstring hardware_id\ndiagnostic_msgs/KeyValue[] values",
    "diagnostic_msgs/DiagnosticArray": "std_msgs/Header header\n"
    "diagnostic_msgs/DiagnosticStatus[] status",
}

PLAIN = {"int32": "std::int32_t", "uint32": "std::uint32_t", "float64": "double",
         "string": "std::string", "byte": "unsigned char"}

RCLCPP = r'''
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#define RCLCPP_WARN(logger, ...) ((void)(logger), std::fprintf(stderr, __VA_ARGS__))

enum rcl_clock_type_t { RCL_ROS_TIME = 1 };

namespace rcl_interfaces::msg {
struct SetParametersResult {
  bool successful = true;
  std::string reason;
};
}  // namespace rcl_interfaces::msg

namespace rclcpp {

class Duration {
 public:
  explicit Duration(std::int64_t ns) : ns_(ns) {}
  double seconds() const { return static_cast<double>(ns_) * 1e-9; }

 private:
  std::int64_t ns_;
};

class Time {
 public:
  Time(std::int32_t s, std::uint32_t ns, rcl_clock_type_t type) : ns_(s * 1000000000LL + ns), type_(type) {}
  Duration operator-(const Time& other) const {
    if (type_ != other.type_) throw std::runtime_error("can't subtract times with different time sources");
    return Duration(ns_ - other.ns_);
  }

 private:
  std::int64_t ns_;
  rcl_clock_type_t type_;
};

using ParameterValue = std::variant<bool, std::int64_t, double, std::string, std::vector<double>>;

class Parameter {
 public:
  template <class T>
  Parameter(const std::string& name, const T& value) : name_(name), value_(value) {}
  const std::string& get_name() const { return name_; }
  const ParameterValue& value() const { return value_; }

 private:
  std::string name_;
  ParameterValue value_;
};

class NodeOptions {
 public:
  NodeOptions& parameter_overrides(std::vector<Parameter> overrides) {
    overrides_ = std::move(overrides);
    return *this;
  }
  const std::vector<Parameter>& parameter_overrides() const { return overrides_; }

 private:
  std::vector<Parameter> overrides_;
};

class QoS {
 public:
  QoS(std::size_t) {}
};

class Logger {};

// What the node of a test did, for the test to look at.
struct Recorded {
  std::map<std::string, std::vector<std::shared_ptr<void>>> published;
  std::map<std::string, std::function<void(std::shared_ptr<void>)>> subscribed;
  std::map<std::string, std::vector<std::vector<Parameter>>> set_parameters;  // by remote node
  std::map<std::string, bool> is_ready;                                       // likewise
  std::int32_t now_s = 100;
};
inline Recorded& recorded() {
  static Recorded all;
  return all;
}

template <class T>
class Publisher {
 public:
  using SharedPtr = std::shared_ptr<Publisher<T>>;
  explicit Publisher(std::string topic) : topic_(std::move(topic)) {}
  void publish(const T& message) { recorded().published[topic_].push_back(std::make_shared<T>(message)); }

 private:
  std::string topic_;
};

template <class T>
class Subscription {
 public:
  using SharedPtr = std::shared_ptr<Subscription<T>>;
};

class Node {
 public:
  Node(const std::string& name, const NodeOptions& options) : name_(name), options_(options) {}
  virtual ~Node() = default;
  const char* get_name() const { return name_.c_str(); }
  Logger get_logger() const { return {}; }
  Time now() const { return {recorded().now_s, 0, RCL_ROS_TIME}; }

  template <class T>
  T declare_parameter(const std::string& name, const T& usual) {
    for (const Parameter& parameter : options_.parameter_overrides()) {
      if (parameter.get_name() == name) return std::get<T>(parameter.value());
    }
    return usual;
  }
  template <class T>
  T declare_parameter(const std::string& name) {
    for (const Parameter& parameter : options_.parameter_overrides()) {
      if (parameter.get_name() == name) return std::get<T>(parameter.value());
    }
    throw std::runtime_error("Statically typed parameter '" + name + "' must be initialized.");
  }

  template <class T>
  std::shared_ptr<Publisher<T>> create_publisher(const std::string& topic, const QoS&) {
    return std::make_shared<Publisher<T>>(topic);
  }
  template <class T, class Callback>
  std::shared_ptr<Subscription<T>> create_subscription(const std::string& topic, const QoS&, Callback callback) {
    recorded().subscribed[topic] = [callback](std::shared_ptr<void> message) {
      callback(std::static_pointer_cast<const T>(message));
    };
    return std::make_shared<Subscription<T>>();
  }

 private:
  std::string name_;
  NodeOptions options_;
};

class AsyncParametersClient {
 public:
  template <class NodeT>
  AsyncParametersClient(NodeT*, const std::string& remote) : remote_(remote) {}
  bool service_is_ready() const { return recorded().is_ready[remote_]; }
  std::shared_future<rcl_interfaces::msg::SetParametersResult> set_parameters_atomically(
      const std::vector<Parameter>& parameters,
      std::function<void(std::shared_future<rcl_interfaces::msg::SetParametersResult>)> = nullptr) {
    recorded().set_parameters[remote_].push_back(parameters);
    return {};
  }

 private:
  std::string remote_;
};

inline void init(int, char**) {}
inline void spin(std::shared_ptr<Node>) {}
inline bool shutdown() { return true; }

}  // namespace rclcpp
'''


def snake_case(name):
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()


def header_of(name):
    package, message = name.split("/")
    return f"{package}/msg/{snake_case(message)}.hpp"


def cpp_type(name):
    if name.endswith("[]"):
        return f"std::vector<{cpp_type(name[:-2])}>"
    if name in PLAIN:
        return PLAIN[name]
    package, message = name.split("/")
    return f"{package}::msg::{message}"


def struct_of(name, definition):
    includes, members = [], []
    package, message = name.split("/")
    for line in definition.splitlines():
        kind, rest = line.split(maxsplit=1)
        if "=" in rest:
            constant, value = rest.split("=")
            members.append(f"  static constexpr {cpp_type(kind)} {constant} = {value};")
            continue
        field, *value = rest.split()
        members.append(f"  {cpp_type(kind)} {field}{{{' '.join(value)}}};")
        plain = kind.removesuffix("[]")
        if plain not in PLAIN:
            includes.append(f"#include <{header_of(plain)}>")
    return "\n".join(
        ["#pragma once", "#include <cstdint>", "#include <memory>", "#include <string>", "#include <vector>",
         *includes, f"namespace {package}::msg {{", f"struct {message} {{", *members,
         f"  using SharedPtr = std::shared_ptr<{message}>;",
         f"  using ConstSharedPtr = std::shared_ptr<const {message}>;", "};", "}", ""])


def main():
    folder = pathlib.Path(sys.argv[1])
    texts = {header_of(name): struct_of(name, definition) for name, definition in MESSAGES.items()}
    texts["rclcpp/rclcpp.hpp"] = "#pragma once\n" + RCLCPP
    for path, text in texts.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text)


if __name__ == "__main__":
    main()
