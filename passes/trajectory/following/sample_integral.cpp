#include "passes/trajectory/following/sample_integral.h"

#include <algorithm>

#include "formats/base/units.h"

namespace sightline {
namespace {

double time_in_s(std::int64_t time_ns) {
  return static_cast<double>(time_ns) / static_cast<double>(kSecond_ns);
}

}  // namespace

void SampleIntegral::add(std::int64_t stamp_ns, const Eigen::Vector3d& value) {
  Node node{stamp_ns, value, {}, 0};
  if (!nodes_.empty()) {
    const Node& before = nodes_.back();
    const bool is_gap = stamp_ns - before.stamp_ns > longest_step_ns_;
    node.gaps_before = before.gaps_before + (is_gap ? 1 : 0);
    const double step_s = time_in_s(stamp_ns - before.stamp_ns);
    const Between& sum = before.from_first;
    node.from_first.once = sum.once + 0.5 * step_s * (before.value + value);
    node.from_first.twice =
        sum.twice + step_s * sum.once + step_s * step_s / 6.0 * (2.0 * before.value + value);
  }
  nodes_.push_back(node);
}

// The last node at or before a time that the nodes cover.
std::size_t SampleIntegral::node_before(std::int64_t stamp_ns) const {
  const auto after = std::ranges::upper_bound(nodes_, stamp_ns, {}, &Node::stamp_ns);
  return static_cast<std::size_t>(after - nodes_.begin()) - 1;
}

SampleIntegral::Between SampleIntegral::from_first(std::size_t node, std::int64_t stamp_ns) const {
  const Node& before = nodes_[node];
  Between sum = before.from_first;
  if (stamp_ns == before.stamp_ns) return sum;
  const Node& after = nodes_[node + 1];
  const double time_s = time_in_s(stamp_ns - before.stamp_ns);
  const Eigen::Vector3d change_per_s =
      (after.value - before.value) / time_in_s(after.stamp_ns - before.stamp_ns);
  sum.twice +=
      time_s * sum.once + time_s * time_s * (0.5 * before.value + time_s / 6.0 * change_per_s);
  sum.once += time_s * (before.value + 0.5 * time_s * change_per_s);
  return sum;
}

std::optional<SampleIntegral::Between> SampleIntegral::between(std::int64_t from_ns,
                                                               std::int64_t to_ns) const {
  if (nodes_.empty() || from_ns < nodes_.front().stamp_ns || to_ns > nodes_.back().stamp_ns) {
    return std::nullopt;
  }
  const std::size_t first = node_before(from_ns);
  const std::size_t last = node_before(to_ns);
  const std::size_t end = nodes_[last].stamp_ns == to_ns ? last : last + 1;
  if (nodes_[end].gaps_before != nodes_[first].gaps_before) return std::nullopt;
  const Between before = from_first(first, from_ns);
  Between sum = from_first(last, to_ns);
  sum.twice -= before.twice + time_in_s(to_ns - from_ns) * before.once;
  sum.once -= before.once;
  return sum;
}

}  // namespace sightline
