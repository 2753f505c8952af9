#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "passes/matching/match_score.h"
#include "passes/trajectory/graph/pose_graph.h"

// Normal equations over poses, in blocks of 6: small motions of each pose along map axes, order dx
// dy dz wx wy wz (m, rad). pose_graph.cpp explains why they exist beside Ceres.

namespace sightline {

using BlockKey = std::pair<std::uint32_t, std::uint32_t>;  // row >= column

struct Equations {
  std::map<BlockKey, Matrix6d> blocks;
  Eigen::VectorXd gradient;
};

void add_block(std::uint32_t row, std::uint32_t column, const Matrix6d& block, Equations& all);

// Adds edges and priors at these poses, each weighted by its sigmas and by Huber's weight of its
// residual. Without priors the first pose is fixed. Earlier terms stay, except those of poses that
// the graph holds: these are no unknowns.
void add_graph(const PoseGraph& graph, const std::vector<Pose>& poses, Equations& all);

// The blocks that add_graph() changes, as they are before; zero where there is none yet. Put back,
// they save a second set of equations: the earlier one, except for terms that couple held poses.
std::map<BlockKey, Matrix6d> blocks_below_graph(const PoseGraph& graph,
                                                const std::vector<Pose>& poses,
                                                const Equations& all);

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
