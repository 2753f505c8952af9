#pragma once

#include <Eigen/Core>

#include "formats/surroundings/ndt_map.h"

namespace sightline {

// Sums over points about the centre of their cell, where they lose least to rounding.
struct CellMoments {
  double count = 0.0;
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d products_m2 = Eigen::Matrix3d::Zero();  // sum of p p^T

  // A point, from the centre. Sign -1 takes away one that was added before.
  void add(const Eigen::Vector3d& from_centre_m, double sign = 1.0);
  // All points of other moments about the same centre.
  void add(const CellMoments& other, double sign = 1.0);
  // All points of an ND, whose mean lies there from the centre.
  void add(const Nd& nd, const Eigen::Vector3d& mean_from_centre_m);

  // About another centre, from which this one lies so far.
  [[nodiscard]] CellMoments seen_from(const Eigen::Vector3d& centre_from_there_m) const;

  // From the centre; of at least one point.
  [[nodiscard]] Eigen::Vector3d mean_m() const { return sum_m / count; }
  // Divided by n - 1; of at least two points.
  [[nodiscard]] Eigen::Matrix3d covariance_m2() const;
};

// The ND of a cell of at least two points, in the frame of the cells.
Nd nd_of(const CellKey& key, const CellMoments& moments, double cell_m);
// Without eigenvalues and eigenvectors: of many NDs decompose() finds them faster together.
Nd undecomposed_nd(const CellKey& key, const CellMoments& moments, double cell_m);

}  // namespace sightline
