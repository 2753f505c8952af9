#include "passes/trajectory/sweep/turn_curve.h"

#include <algorithm>

#include "formats/base/units.h"

namespace sightline {
namespace {

// Half of a scan: rarer rates do not measure the turning within one.
constexpr std::int64_t kLongestStep_ns = 50'000'000;

double share_of(std::int64_t time_ns, std::int64_t from_ns, std::int64_t to_ns) {
  return static_cast<double>(time_ns - from_ns) / static_cast<double>(to_ns - from_ns);
}

Eigen::Vector3d rate_between(const TurnRate& before, const TurnRate& after, std::int64_t time_ns) {
  const double share = share_of(time_ns, before.stamp_ns, after.stamp_ns);
  return before.rate_rad_per_s + share * (after.rate_rad_per_s - before.rate_rad_per_s);
}

// The rotation while a rate changes linearly: exact to the second order in time.
Eigen::Matrix3d turned(const Eigen::Vector3d& first_radps, const Eigen::Vector3d& last_radps,
                       std::int64_t duration_ns) {
  const Eigen::Vector3d turn_rad =
      0.5 * (first_radps + last_radps) *
      (static_cast<double>(duration_ns) / static_cast<double>(kSecond_ns));
  const double angle_rad = turn_rad.norm();
  if (angle_rad == 0.0) return Eigen::Matrix3d::Identity();
  return rotation_matrix({turn_rad / angle_rad, angle_rad});
}

}  // namespace

std::span<const TurnRate> rates_around(std::span<const TurnRate> rates, std::int64_t from_ns,
                                       std::int64_t to_ns) {
  auto first = std::ranges::upper_bound(rates, from_ns, {}, &TurnRate::stamp_ns);
  if (first != rates.begin()) --first;
  auto last = std::ranges::lower_bound(rates, to_ns, {}, &TurnRate::stamp_ns);
  if (last != rates.end()) ++last;
  return first < last ? std::span<const TurnRate>(first, last) : std::span<const TurnRate>();
}

std::optional<TurnCurve> TurnCurve::integrated(std::span<const TurnRate> rates,
                                               std::int64_t from_ns, std::int64_t to_ns) {
  const std::span<const TurnRate> around = rates_around(rates, from_ns, to_ns);
  if (around.size() < 2 || around.front().stamp_ns > from_ns || around.back().stamp_ns < to_ns) {
    return std::nullopt;
  }
  TurnCurve curve;
  curve.nodes_.emplace_back();
  curve.nodes_.back().time_ns = from_ns;
  curve.nodes_.back().rate_rad_per_s = rate_between(around[0], around[1], from_ns);
  for (std::size_t i = 1; i < around.size(); ++i) {
    const TurnRate& before = around[i - 1];
    const TurnRate& after = around[i];
    if (after.stamp_ns - before.stamp_ns > kLongestStep_ns) return std::nullopt;
    const Node from = curve.nodes_.back();
    const std::int64_t time_ns = std::min(after.stamp_ns, to_ns);
    const Eigen::Vector3d rate_radps = rate_between(before, after, time_ns);
    const Eigen::Matrix3d turn = turned(from.rate_rad_per_s, rate_radps, time_ns - from.time_ns);
    curve.nodes_.push_back({time_ns, rate_radps, from.R_from_node * turn});
  }
  return curve;
}

std::optional<TurnCurve> TurnCurve::between(std::span<const TurnRate> rates, const TurnEnds& ends) {
  std::optional<TurnCurve> curve = integrated(rates, ends.from_ns, ends.to_ns);
  if (!curve) return curve;
  const Eigen::Matrix3d R_from_to = ends.R_map_from.transpose() * ends.R_map_to;
  curve->ends_ = ends;
  curve->left_over_ = axis_angle(curve->nodes_.back().R_from_node.transpose() * R_from_to);
  return curve;
}

std::optional<TurnCurve> TurnCurve::by_rates(std::span<const TurnRate> rates, std::int64_t from_ns,
                                             std::int64_t to_ns) {
  std::optional<TurnCurve> curve = integrated(rates, from_ns, to_ns);
  if (!curve) return curve;
  curve->ends_.from_ns = from_ns;
  curve->ends_.to_ns = to_ns;
  curve->ends_.R_map_to = curve->nodes_.back().R_from_node;
  return curve;
}

Eigen::Matrix3d TurnCurve::at(std::int64_t time_ns) const {
  if (time_ns <= ends_.from_ns) return ends_.R_map_from;
  if (time_ns >= ends_.to_ns) return ends_.R_map_to;
  const auto after = std::ranges::upper_bound(nodes_, time_ns, {}, &Node::time_ns);
  const Node& from = *std::prev(after);
  const double share = share_of(time_ns, from.time_ns, after->time_ns);
  const Eigen::Vector3d rate_radps =
      from.rate_rad_per_s + share * (after->rate_rad_per_s - from.rate_rad_per_s);
  const double s = share_of(time_ns, ends_.from_ns, ends_.to_ns);
  return ends_.R_map_from * from.R_from_node *
         turned(from.rate_rad_per_s, rate_radps, time_ns - from.time_ns) *
         rotation_matrix({left_over_.axis, s * left_over_.angle_rad});
}

double TurnCurve::bend_rad() const {
  const AxisAngle whole = axis_angle(ends_.R_map_from.transpose() * ends_.R_map_to);
  double most_rad = 0.0;
  for (const Node& node : nodes_) {
    const double s = share_of(node.time_ns, ends_.from_ns, ends_.to_ns);
    const Eigen::Matrix3d R_map_even =
        ends_.R_map_from * rotation_matrix({whole.axis, s * whole.angle_rad});
    most_rad = std::max(most_rad, rotation_angle_rad(R_map_even.transpose() * at(node.time_ns)));
  }
  return most_rad;
}

}  // namespace sightline
