#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace sightline {

// A measured quantity, linear between samples, and its integrals over time.
class SampleIntegral {
 public:
  // Ascending in time. Samples more than `longest_step_ns` apart have nothing between them.
  explicit SampleIntegral(std::int64_t longest_step_ns) : longest_step_ns_(longest_step_ns) {}
  void add(std::int64_t stamp_ns, const Eigen::Vector3d& value);

  struct Between {
    Eigen::Vector3d once =
        Eigen::Vector3d::Zero();  // of the value, from the first to the second time
    Eigen::Vector3d twice = Eigen::Vector3d::Zero();  // of that integral, which begins with zero
  };
  // None where the samples do not cover the time from `from_ns` to `to_ns`, which is not earlier.
  [[nodiscard]] std::optional<Between> between(std::int64_t from_ns, std::int64_t to_ns) const;

 private:
  struct Node {
    std::int64_t stamp_ns = 0;
    Eigen::Vector3d value = Eigen::Vector3d::Zero();
    Between from_first;  // from the first node to this one
    std::size_t gaps_before = 0;
  };
  [[nodiscard]] std::size_t node_before(std::int64_t stamp_ns) const;
  [[nodiscard]] Between from_first(std::size_t node, std::int64_t stamp_ns) const;

  std::int64_t longest_step_ns_;
  std::vector<Node> nodes_;
};

}  // namespace sightline
