#pragma once

#include <Eigen/Core>
#include <vector>

// Lines of lanes in the plane. Points are in world coordinates, m; lengths leave heights out.

namespace sightline {

// A line that is asked for places by their share of its length. One point or more.
class LineByShare {
 public:
  explicit LineByShare(std::vector<Eigen::Vector3d> points_m);
  [[nodiscard]] double length_m() const { return until_m_.back(); }
  // The begin of the segment that the place lies in, and where between its ends, 0 to 1.
  struct Place {
    std::size_t segment = 0;
    double within = 0.0;
  };
  [[nodiscard]] Place place(double share) const;  // 0: the begin, 1: the end
  [[nodiscard]] Eigen::Vector3d at(double share) const;
  [[nodiscard]] const std::vector<Eigen::Vector3d>& points_m() const { return points_m_; }

 private:
  std::vector<Eigen::Vector3d> points_m_;
  std::vector<double> until_m_;  // from the begin to each point
};

// Above 0 where a place lies on the left of a line that is followed from its begin to its end.
double left_of(const std::vector<Eigen::Vector3d>& line_m, const Eigen::Vector3d& p_m);

// Halfway between places of equal share of two lines that run the same way, steps + 1 points.
std::vector<Eigen::Vector3d> middle_of(const LineByShare& left, const LineByShare& right,
                                       std::size_t steps);

}  // namespace sightline
