#include "tests/bench/integrity/loop_table.h"

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace sightline {
namespace {

constexpr double kLost_m = 0.5;
// 95 % of chi-squared, by degrees of freedom.
constexpr std::array<double, 4> kInside = {0.0, 3.841, 5.991, 7.815};

// Of the information of x, y and yaw alone: unknown beyond 100 m and 1 rad.
Eigen::Matrix3d covariance_of_information(Eigen::Matrix3d information) {
  information.diagonal() += Eigen::Vector3d(1e-4, 1e-4, 1.0);
  return information.inverse();
}

double rms(double squares, std::size_t count) {
  return count == 0 ? 0.0 : std::sqrt(squares / static_cast<double>(count));
}

}  // namespace

void Consistency::add(const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance,
                      const bool (&used)[3]) {
  std::vector<int> axes;
  for (int i = 0; i < 3; ++i) {
    if (used[i]) axes.push_back(i);
  }
  const auto size = static_cast<Eigen::Index>(axes.size());
  Eigen::MatrixXd part(size, size);
  Eigen::VectorXd off(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    off[i] = error[axes[static_cast<std::size_t>(i)]];
    for (Eigen::Index j = 0; j < size; ++j) {
      part(i, j) = covariance(axes[static_cast<std::size_t>(i)], axes[static_cast<std::size_t>(j)]);
    }
  }
  const Eigen::VectorXd pull = part.partialPivLu().solve(off);
  const double squared = off.dot(pull);
  squared_sum += squared;
  freedom += axes.size();
  ++count;
  inside += squared <= kInside[axes.size()] ? 1 : 0;
}

double Consistency::per_freedom() const {
  return freedom == 0 ? 0.0 : squared_sum / static_cast<double>(freedom);
}

double Consistency::inside_percent() const {
  return count == 0 ? 0.0 : 100.0 * static_cast<double>(inside) / static_cast<double>(count);
}

void add_loop(std::span<const LoopStep> steps, LoopSummaries& summaries) {
  constexpr bool kAll[3] = {true, true, true};
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const LoopStep& step = steps[k];
    LoopSummary& summary = summaries[step.kind];
    ++summary.scans;
    summary.fused.add(step.fused_error, step.fused_covariance, kAll);
    summary.fused_squares += step.fused_error.cwiseAbs2();
    if (k + 1 == steps.size() || steps[k + 1].kind != step.kind) {
      summary.end_forward_m.push_back(step.fused_error.x());
    }
    if (!step.is_constrained[0] || !step.is_constrained[1]) ++summary.unconstrained;
    if (!step.is_matched) continue;
    bool is_lost = false;
    for (int i = 0; i < 2; ++i) {
      is_lost = is_lost || (step.is_constrained[i] && std::abs(step.match_error[i]) > kLost_m);
    }
    summary.match_squares += step.returned_error.cwiseAbs2();
    summary.start_squares += step.start_error.cwiseAbs2();
    summary.returned.add(step.returned_error, step.match_covariance, kAll);
    if (is_lost) {
      ++summary.lost;
      continue;
    }
    summary.match.add(step.match_error, covariance_of_information(step.information),
                      step.is_constrained);
  }
}

void print_heading() {
  std::printf(
      "%-11s %-13s %6s %5s %5s | %8s %5s | %8s %5s | %6s %6s %6s | %8s %5s | %6s %6s %6s | %s\n",
      "source", "kind", "scans", "weak", "lost", "NEES", "in95", "returned", "in95", "ahead",
      "left", "yaw", "fused", "in95", "ahead", "left", "yaw", "end");
}

void print_row(const std::string& source, const std::string& kind, const LoopSummary& summary) {
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  double end_squares = 0.0;
  for (const double end_m : summary.end_forward_m) end_squares += end_m * end_m;
  const auto m = [&](int i) { return rms(summary.match_squares[i], summary.scans); };
  const auto f = [&](int i) { return rms(summary.fused_squares[i], summary.scans); };
  std::printf(
      "%-11s %-13s %6zu %5zu %5zu | %8.2f %5.1f | %8.2f %5.1f | %6.3f %6.3f %6.3f | %8.2f %5.1f | "
      "%6.3f %6.3f %6.3f | %.3f\n",
      source.c_str(), kind.c_str(), summary.scans, summary.unconstrained, summary.lost,
      summary.match.per_freedom(), summary.match.inside_percent(), summary.returned.per_freedom(),
      summary.returned.inside_percent(), m(0), m(1), kDegrees * m(2), summary.fused.per_freedom(),
      summary.fused.inside_percent(), f(0), f(1), kDegrees * f(2),
      rms(end_squares, summary.end_forward_m.size()));
}

}  // namespace sightline
