#pragma once

#include <Eigen/Core>
#include <span>

// The eigenvalues of small symmetric matrices. Eigen's own template takes a compiler five seconds
// in every file that uses it; here it is compiled once.

namespace sightline {

template <int N>
struct SymmetricEigen {
  Eigen::Matrix<double, N, 1> values;   // ascending
  Eigen::Matrix<double, N, N> vectors;  // of unit length, in columns, in the order of `values`
};

// Only the lower triangle of `matrix`, of 2, 3 or 6 rows, is read. Its elements are finite. Of 3
// rows, what is below 2^-44 of the largest element, beside the diagonal, is taken for rounding.
template <int N>
SymmetricEigen<N> symmetric_eigen(const Eigen::Matrix<double, N, N>& matrix);

// The same of many matrices, as many as `found` has room for: to the bit, and faster.
void symmetric_eigen(std::span<const Eigen::Matrix3d> matrices, std::span<SymmetricEigen<3>> found);

}  // namespace sightline
