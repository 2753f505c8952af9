#include "passes/trajectory/graph/normal_solver.h"

#include <Eigen/OrderingMethods>
#include <algorithm>
#include <cstddef>
#include <tuple>

namespace sightline {
namespace {

// A block and its place in the matrix.
struct PlacedBlock {
  std::uint32_t column = 0;
  std::uint32_t row = 0;  // <= column
  bool is_turned = false;
  const Matrix6d* block = nullptr;
};

std::vector<PlacedBlock> placed_blocks(const Equations& all,
                                       const std::vector<std::uint32_t>& place_of) {
  std::vector<PlacedBlock> placed;
  placed.reserve(all.blocks.size());
  for (const auto& [key, block] : all.blocks) {
    const std::uint32_t row = place_of[key.first];
    const std::uint32_t column = place_of[key.second];
    // A block below the diagonal is stored above it as its transpose. Of a block on the diagonal
    // the lower triangle counts.
    const bool is_turned = row >= column;
    placed.push_back({std::max(row, column), std::min(row, column), is_turned, &block});
  }
  std::ranges::sort(placed, {},
                    [](const PlacedBlock& one) { return std::pair(one.column, one.row); });
  return placed;
}

// Of (L L^T)^-1 = Z the entries where L has any, in the order of L, whose rows ascend in each
// column with the diagonal first. Of column j, below the diagonal,
//   Z_ij = -sum_k Z_ik L_kj / L_jj and then Z_jj = (1 / L_jj - sum_k L_kj Z_kj) / L_jj,
// with k over the rows of column j. Where i and k are among these, L has an entry (i, k) too.
std::vector<double> inverse_where_held(const Eigen::SparseMatrix<double>& L) {
  const int* const begin = L.outerIndexPtr();
  const int* const rows = L.innerIndexPtr();
  const double* const values = L.valuePtr();
  std::vector<double> held(static_cast<std::size_t>(L.nonZeros()));
  double* const inverse = held.data();
  std::vector<int> places(static_cast<std::size_t>(L.rows()), -1);
  int* const place_of = places.data();  // in the column, of its rows
  std::vector<double> sums;
  for (int j = static_cast<int>(L.cols()) - 1; j >= 0; --j) {
    const int first = begin[j] + 1;
    const int count = begin[j + 1] - first;
    sums.assign(static_cast<std::size_t>(count), 0.0);
    for (int n = 0; n < count; ++n) place_of[rows[first + n]] = n;
    for (int n = 0; n < count; ++n) {
      const int k = rows[first + n];
      const double of_k = values[first + n];
      double sum = of_k * inverse[begin[k]];
      for (int at = begin[k] + 1; at < begin[k + 1]; ++at) {
        const int place = place_of[rows[at]];
        if (place < 0) continue;
        sum += inverse[at] * values[first + place];
        sums[static_cast<std::size_t>(place)] += inverse[at] * of_k;
      }
      sums[static_cast<std::size_t>(n)] += sum;
    }
    const double diagonal = values[begin[j]];
    double own = 1.0 / diagonal;
    for (int n = 0; n < count; ++n) {
      const double entry = -sums[static_cast<std::size_t>(n)] / diagonal;
      inverse[first + n] = entry;
      own -= values[first + n] * entry;
      place_of[rows[first + n]] = -1;
    }
    inverse[begin[j]] = own / diagonal;
  }
  return held;
}

}  // namespace

std::vector<std::uint32_t> elimination_places(const Equations& all) {
  const Eigen::Index poses = all.gradient.size() / 6;
  std::vector<Eigen::Triplet<double, int>> pairs;
  pairs.reserve(all.blocks.size());
  for (const auto& [key, block] : all.blocks) {
    pairs.emplace_back(static_cast<int>(key.first), static_cast<int>(key.second), 1.0);
  }
  Eigen::SparseMatrix<double> coupled(poses, poses);
  coupled.setFromTriplets(pairs.begin(), pairs.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
  Eigen::AMDOrdering<int>()(coupled.selfadjointView<Eigen::Lower>(), order);
  std::vector<std::uint32_t> place_of(static_cast<std::size_t>(poses));
  for (Eigen::Index place = 0; place < poses; ++place) {
    place_of[static_cast<std::size_t>(order.indices()[place])] = static_cast<std::uint32_t>(place);
  }
  return place_of;
}

// Written in place: triplets of a long street would double the memory.
Eigen::SparseMatrix<double> upper_matrix(const Equations& all,
                                         const std::vector<std::uint32_t>& place_of) {
  const std::vector<PlacedBlock> placed = placed_blocks(all, place_of);
  const Eigen::Index size = all.gradient.size();
  Eigen::SparseMatrix<double> matrix(size, size);
  int* const begin = matrix.outerIndexPtr();  // of each column
  for (const PlacedBlock& one : placed) {
    for (std::uint32_t j = 0; j < 6; ++j) begin[6 * one.column + j + 1] += 6;
  }
  for (Eigen::Index column = 0; column < size; ++column) begin[column + 1] += begin[column];
  matrix.resizeNonZeros(begin[size]);
  std::vector<int> next(begin, begin + size);
  for (const PlacedBlock& one : placed) {
    for (int j = 0; j < 6; ++j) {
      int& place = next[6 * one.column + static_cast<unsigned>(j)];
      for (int i = 0; i < 6; ++i, ++place) {
        matrix.innerIndexPtr()[place] = static_cast<int>(6 * one.row) + i;
        matrix.valuePtr()[place] = one.is_turned ? (*one.block)(j, i) : (*one.block)(i, j);
      }
    }
  }
  return matrix;
}

bool NormalSolver::factor(const Equations& all) {
  place_of_ = elimination_places(all);
  llt_.compute(upper_matrix(all, place_of_));
  return llt_.info() == Eigen::Success;
}

Eigen::VectorXd NormalSolver::solve(const Eigen::VectorXd& right) const {
  Eigen::VectorXd placed(right.size());
  for (std::size_t pose = 0; pose < place_of_.size(); ++pose) {
    placed.segment<6>(6 * static_cast<Eigen::Index>(place_of_[pose])) =
        right.segment<6>(6 * static_cast<Eigen::Index>(pose));
  }
  const Eigen::VectorXd found = llt_.solve(placed);
  Eigen::VectorXd solution(right.size());
  for (std::size_t pose = 0; pose < place_of_.size(); ++pose) {
    solution.segment<6>(6 * static_cast<Eigen::Index>(pose)) =
        found.segment<6>(6 * static_cast<Eigen::Index>(place_of_[pose]));
  }
  return solution;
}

std::vector<Matrix6d> NormalSolver::inverse_blocks() const {
  const Eigen::SparseMatrix<double>& factor = llt_.matrixL().nestedExpression();
  const std::vector<double> inverse = inverse_where_held(factor);
  std::vector<Matrix6d> blocks(place_of_.size());
  for (std::size_t pose = 0; pose < place_of_.size(); ++pose) {
    const auto first = static_cast<int>(6 * place_of_[pose]);
    for (int j = 0; j < 6; ++j) {
      // Below the diagonal come the rows of the same pose first.
      const auto at = static_cast<std::size_t>(factor.outerIndexPtr()[first + j]);
      for (int i = j; i < 6; ++i) {
        blocks[pose](i, j) = blocks[pose](j, i) = inverse[at + static_cast<std::size_t>(i - j)];
      }
    }
  }
  return blocks;
}

}  // namespace sightline
