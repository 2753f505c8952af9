#pragma once

#include <rclcpp/rclcpp.hpp>

// A node with states; the test calls the transitions.

namespace rclcpp_lifecycle {

class State {};

namespace node_interfaces {
class LifecycleNodeInterface {
 public:
  enum class CallbackReturn { SUCCESS, FAILURE, ERROR };
  virtual ~LifecycleNodeInterface() = default;
  virtual CallbackReturn on_configure(const State&) { return CallbackReturn::SUCCESS; }
  virtual CallbackReturn on_cleanup(const State&) { return CallbackReturn::SUCCESS; }
  virtual CallbackReturn on_shutdown(const State&) { return CallbackReturn::SUCCESS; }
  virtual CallbackReturn on_activate(const State&) { return CallbackReturn::SUCCESS; }
  virtual CallbackReturn on_deactivate(const State&) { return CallbackReturn::SUCCESS; }
};
}  // namespace node_interfaces

// Publishes only while its node is active.
template <class T>
class LifecyclePublisher : public rclcpp::Publisher<T> {
 public:
  using SharedPtr = std::shared_ptr<LifecyclePublisher<T>>;
  LifecyclePublisher(const std::string& topic, const bool& is_active)
      : rclcpp::Publisher<T>(topic), is_active_(is_active) {}
  void publish(const T& message) override {
    if (is_active_) rclcpp::Publisher<T>::publish(message);
  }

 private:
  const bool& is_active_;
};

class LifecycleNode : public rclcpp::Node, public node_interfaces::LifecycleNodeInterface {
 public:
  using rclcpp::Node::Node;
  template <class T>
  std::shared_ptr<LifecyclePublisher<T>> create_publisher(const std::string& topic, const rclcpp::QoS&) {
    return std::make_shared<LifecyclePublisher<T>>(topic, is_active_);
  }
  CallbackReturn on_activate(const State&) override {
    is_active_ = true;
    return CallbackReturn::SUCCESS;
  }
  CallbackReturn on_deactivate(const State&) override {
    is_active_ = false;
    return CallbackReturn::SUCCESS;
  }

 private:
  bool is_active_ = false;
};

}  // namespace rclcpp_lifecycle
