#include "formats/symmetric_eigen.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "formats/base/check.h"

namespace sightline {
namespace {

// For 2 and 6 rows one solver: to compile, each of its own size takes as long, and gives the same
// bits.
using Solved = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6>;

// Two numbers whose product is 2^exponent, each a double where the product is none.
std::pair<double, double> powers_of_two(int exponent) {
  const int half = exponent / 2;
  return {std::ldexp(1.0, half), std::ldexp(1.0, exponent - half)};
}

// Of 3 rows there are so many matrices, one for each ND, that they are solved several at a time, by
// Jacobi's rotations (Golub and Van Loan, Matrix Computations, section 8.5), which are sums,
// products and roots alone: the same bits on each machine, and, since a matrix without anything
// beside its diagonal is not turned any more, whatever its neighbours are.
template <int kCount>
class Rotations {
 public:
  // The last ones may be repetitions.
  void set(int lane, const Eigen::Matrix3d& matrix) {
    double most = 0.0;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j <= i; ++j) most = std::max(most, std::abs(matrix(i, j)));
    }
    if (most > 0.0 && std::isfinite(most)) exponent_[lane] = std::ilogb(most);
    const auto [scale, more] = powers_of_two(-exponent_[lane]);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j <= i; ++j) a_[i][j][lane] = more * (scale * matrix(i, j));
    }
  }

  void solve() {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) v_[i][j] = i == j ? 1.0 : 0.0;
    }
    constexpr int kMostSweeps = 30;  // four or five do, unless numbers are not finite
    for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
      const bool has_turned[] = {turn(0, 1), turn(0, 2), turn(1, 2)};
      if (!has_turned[0] && !has_turned[1] && !has_turned[2]) break;
    }
  }

  [[nodiscard]] SymmetricEigen<3> result(int lane) const {
    int order[] = {0, 1, 2};
    const auto sort = [&](int& low, int& high) {
      if (a_[high][high][lane] < a_[low][low][lane]) std::swap(low, high);
    };
    sort(order[0], order[1]);
    sort(order[1], order[2]);
    sort(order[0], order[1]);
    const auto [scale, more] = powers_of_two(exponent_[lane]);
    SymmetricEigen<3> eigen;
    for (int i = 0; i < 3; ++i) {
      eigen.values[i] = more * (scale * a_[order[i]][order[i]][lane]);
      for (int row = 0; row < 3; ++row) eigen.vectors(row, i) = v_[row][order[i]][lane];
    }
    return eigen;
  }

 private:
  using Lanes = Eigen::Array<double, kCount, 1>;

  // Makes the elements at (p, q), p < q, zero. False where they are in all matrices.
  bool turn(int p, int q) {
    const Lanes app = a_[p][p];
    const Lanes aqq = a_[q][q];
    // What is left of sums over points whose axes are those of the map: a distribution that is
    // round shall not be turned by it.
    constexpr double kRounding = 0x1.0p-44;  // of elements whose largest is near 1
    const Lanes apq = (a_[q][p].abs() <= kRounding).select(0.0, a_[q][p]);
    a_[q][p] = 0.0;
    if (!(apq != 0.0).any()) return false;
    // The tangent of the smaller of the two angles that do.
    const Lanes apart = aqq - app;
    const Lanes twice = 2.0 * apq;
    const Lanes above = (apart < 0.0).select(-twice, twice);
    constexpr double kNotZero = 1e-300;
    const Lanes tangent =
        above / (apart.abs() + (apart * apart + twice * twice).sqrt()).max(kNotZero);
    const Lanes cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
    const Lanes sine = tangent * cosine;
    a_[p][p] = app - tangent * apq;
    a_[q][q] = aqq + tangent * apq;
    const int r = 3 - p - q;
    turn(cosine, sine, a_[std::max(r, p)][std::min(r, p)], a_[std::max(r, q)][std::min(r, q)]);
    for (int row = 0; row < 3; ++row) turn(cosine, sine, v_[row][p], v_[row][q]);
    return true;
  }

  static void turn(const Lanes& cosine, const Lanes& sine, Lanes& p, Lanes& q) {
    const Lanes before = p;
    p = cosine * before - sine * q;
    q = sine * before + cosine * q;
  }

  Lanes a_[3][3];  // the lower triangle, turned until nothing is left beside the diagonal
  Lanes v_[3][3];  // all turns
  int exponent_[kCount] = {};
};

}  // namespace

template <int N>
SymmetricEigen<N> symmetric_eigen(const Eigen::Matrix<double, N, N>& matrix) {
  const Eigen::SelfAdjointEigenSolver<Solved> solver{Solved(matrix)};
  return {solver.eigenvalues(), solver.eigenvectors()};
}

template <>
SymmetricEigen<3> symmetric_eigen<3>(const Eigen::Matrix3d& matrix) {
  Rotations<1> rotations;
  rotations.set(0, matrix);
  rotations.solve();
  return rotations.result(0);
}

template SymmetricEigen<2> symmetric_eigen<2>(const Eigen::Matrix<double, 2, 2>& matrix);
template SymmetricEigen<6> symmetric_eigen<6>(const Eigen::Matrix<double, 6, 6>& matrix);

void symmetric_eigen(std::span<const Eigen::Matrix3d> matrices,
                     std::span<SymmetricEigen<3>> found) {
  SIGHTLINE_CHECK(matrices.size() == found.size());
  constexpr std::size_t kAtOnce = 8;
  for (std::size_t first = 0; first < matrices.size(); first += kAtOnce) {
    const std::size_t count = std::min(kAtOnce, matrices.size() - first);
    Rotations<kAtOnce> rotations;
    for (std::size_t i = 0; i < kAtOnce; ++i) {
      rotations.set(static_cast<int>(i), matrices[first + std::min(i, count - 1)]);
    }
    rotations.solve();
    for (std::size_t i = 0; i < count; ++i) {
      found[first + i] = rotations.result(static_cast<int>(i));
    }
  }
}

}  // namespace sightline
