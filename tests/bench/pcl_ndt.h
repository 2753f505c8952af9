#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

// PCL's own tools for the same jobs, to compare with. PCL stays in its own .cpp: it must not see
// our vector flags, nor we its headers.

namespace sightline {

// The finite points of a PCD file that are not (0,0,0); empty where it cannot be read.
std::vector<Eigen::Vector3d> read_pcd_with_pcl(const std::string& path);

// PCL's NDT with our stop rule (it compares the square of a step with its epsilon), default step.
class PclNdt {
 public:
  PclNdt(std::span<const Eigen::Vector3d> map_points_m, double cell_m);
  ~PclNdt();
  PclNdt(const PclNdt&) = delete;
  PclNdt& operator=(const PclNdt&) = delete;

  void set_scan(std::span<const Eigen::Vector3d> points_m);
  Eigen::Matrix4d match(const Eigen::Matrix4d& T_map_start);
  // One evaluation of score, gradient and Hessian at a pose, after a first match; the score.
  double evaluate(const Eigen::Matrix4d& T_map_scan);

 private:
  struct State;
  State* state_;
};

}  // namespace sightline
