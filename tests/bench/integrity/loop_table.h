#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "tests/bench/integrity/closed_loop.h"

namespace sightline {

// Sums of squared errors over what was predicted of them, by degree of freedom.
struct Consistency {
  double squared_sum = 0.0;  // e^T S^-1 e
  std::size_t freedom = 0;
  std::size_t count = 0;
  std::size_t inside = 0;  // the 95 % region

  void add(const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance, const bool (&used)[3]);
  [[nodiscard]] double per_freedom() const;
  [[nodiscard]] double inside_percent() const;
};

// What became of the scans at one kind of place.
struct LoopSummary {
  Consistency match;     // constrained directions, of the information alone
  Consistency returned;  // all directions, of the returned pose
  Consistency fused;     // all directions
  Eigen::Vector3d match_squares = Eigen::Vector3d::Zero();  // of the returned pose
  Eigen::Vector3d start_squares = Eigen::Vector3d::Zero();
  Eigen::Vector3d fused_squares = Eigen::Vector3d::Zero();
  std::vector<double> end_forward_m;  // fused, at the last scan of each drive there
  std::size_t scans = 0;
  std::size_t lost = 0;           // 0.5 m off in a constrained direction; not in `match`
  std::size_t unconstrained = 0;  // scans with a direction that is not constrained
};

// By kind of place; adds to what is there.
using LoopSummaries = std::map<std::string, LoopSummary>;
void add_loop(std::span<const LoopStep> steps, LoopSummaries& summaries);
void print_row(const std::string& source, const std::string& kind, const LoopSummary& summary);
void print_heading();

}  // namespace sightline
