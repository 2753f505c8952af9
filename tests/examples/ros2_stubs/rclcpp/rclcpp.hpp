#pragma once

// Of rclcpp the calls that the nodes of examples/ros2 use; they record what the nodes did.

#include <builtin_interfaces/msg/time.hpp>
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
#define RCLCPP_ERROR(logger, ...) ((void)(logger), std::fprintf(stderr, __VA_ARGS__))

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
  std::int64_t nanoseconds() const { return ns_; }

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
  QoS& keep_last(std::size_t) { return *this; }
};
class SensorDataQoS : public QoS {
 public:
  SensorDataQoS() : QoS(5) {}
};

class Clock {
 public:
  using SharedPtr = std::shared_ptr<Clock>;
};

class Logger {};

// What the node of a test did, for the test to look at.
struct Recorded {
  std::map<std::string, std::vector<std::shared_ptr<void>>> published;
  std::map<std::string, std::function<void(std::shared_ptr<void>)>> subscribed;
  std::map<std::string, std::size_t> subscriber_count;  // of topics that a node publishes
  std::map<std::string, std::function<void(std::shared_ptr<void>, std::shared_ptr<void>)>> services;
  std::vector<std::function<void()>> timers;
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
  virtual ~Publisher() = default;
  std::size_t get_subscription_count() const { return recorded().subscriber_count[topic_]; }
  virtual void publish(const T& message) { recorded().published[topic_].push_back(std::make_shared<T>(message)); }

 private:
  std::string topic_;
};

template <class T>
class Subscription {
 public:
  using SharedPtr = std::shared_ptr<Subscription<T>>;
};

template <class T>
class Service {
 public:
  using SharedPtr = std::shared_ptr<Service<T>>;
};

class TimerBase {
 public:
  using SharedPtr = std::shared_ptr<TimerBase>;
};

class Node {
 public:
  Node(const std::string& name, const NodeOptions& options) : name_(name), options_(options) {}
  virtual ~Node() = default;
  const char* get_name() const { return name_.c_str(); }
  Logger get_logger() const { return {}; }
  Clock::SharedPtr get_clock() const { return std::make_shared<Clock>(); }
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

  template <class T, class Callback>
  std::shared_ptr<Service<T>> create_service(const std::string& name, Callback callback) {
    recorded().services[name] = [callback](std::shared_ptr<void> request, std::shared_ptr<void> response) {
      callback(std::static_pointer_cast<typename T::Request>(request),
               std::static_pointer_cast<typename T::Response>(response));
    };
    return std::make_shared<Service<T>>();
  }
  template <class Callback>
  TimerBase::SharedPtr create_wall_timer(std::chrono::seconds, Callback callback) {
    recorded().timers.push_back(callback);
    return std::make_shared<TimerBase>();
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
