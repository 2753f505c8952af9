#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <cstdint>
#include <vector>

#include "passes/matching/match_score.h"
#include "passes/trajectory/graph/normal_equations.h"

namespace sightline {

// Solves normal equations by sparse Cholesky. The order of elimination is by pose, found by
// approximate minimum degree (Amestoy, Davis, Duff, 1996): to find one by unknown, six for each
// pose, would take four times the memory of everything else here.
class NormalSolver {
 public:
  // Keeps the factors of the matrix; false where it is not positive definite.
  [[nodiscard]] bool factor(const Equations& all);
  // The solution x of: matrix x = `right`.
  [[nodiscard]] Eigen::VectorXd solve(const Eigen::VectorXd& right) const;
  // The blocks of all poses on the diagonal of the inverse, from its entries where the factor has
  // any (Takahashi, Fagan, Chin, 1973; Erisman and Tinney, 1975): time and memory are those of
  // factoring, where solving for each pose would take the square of the poses.
  [[nodiscard]] std::vector<Matrix6d> inverse_blocks() const;

 private:
  std::vector<std::uint32_t> place_of_;  // of each pose, in the order of elimination
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Upper, Eigen::NaturalOrdering<int>> llt_;
};

// The places of poses in an order of elimination that fills in little.
std::vector<std::uint32_t> elimination_places(const Equations& all);

// The matrix with its poses at these places; blocks on and above the diagonal.
Eigen::SparseMatrix<double> upper_matrix(const Equations& all,
                                         const std::vector<std::uint32_t>& place_of);

}  // namespace sightline
