#include "passes/trajectory/graph/normal_equations.h"

#include <Eigen/Geometry>
#include <Eigen/OrderingMethods>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "formats/geometry.h"

namespace sightline {
namespace {

// Sigmas of a fixed pose.
constexpr double kFixed_m = 1e-4;
constexpr double kFixed_rad = 1e-6;

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d matrix;
  matrix << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return matrix;
}

Vector6d information_of(double sigma_m, double sigma_rad) {
  Vector6d information;
  information.head<3>().setConstant(1.0 / (sigma_m * sigma_m));
  information.tail<3>().setConstant(1.0 / (sigma_rad * sigma_rad));
  return information;
}

// Huber's weight of a residual that is as long as so many sigmas.
double huber(double sigmas) { return sigmas > 1.0 ? 1.0 / sigmas : 1.0; }

// Residuals in map axes: the pose of `to` less that by `from`.
void add_edge(const GraphEdge& edge, const std::vector<Pose>& poses, Equations& all) {
  const Pose& from = poses[edge.from];
  const Pose expected = from * edge.T_from_to;
  const Pose& to = poses[edge.to];
  Vector6d residual;
  residual << to.translation() - expected.translation(),
      rotation_vector(to.linear() * expected.linear().transpose());
  Vector6d information = information_of(edge.sigma_m, edge.sigma_rad);
  information *= huber(std::sqrt(residual.dot(information.cwiseProduct(residual))));
  Matrix6d by_from = -Matrix6d::Identity();
  by_from.block<3, 3>(0, 3) = cross_matrix(expected.translation() - from.translation());
  const Matrix6d weighted = by_from.transpose() * information.asDiagonal();
  const Matrix6d own = information.asDiagonal();
  add_block(edge.from, edge.from, weighted * by_from, all);
  add_block(edge.to, edge.to, own, all);
  if (edge.from < edge.to) {
    add_block(edge.to, edge.from, own * by_from, all);
  } else {
    add_block(edge.from, edge.to, weighted, all);
  }
  all.gradient.segment<6>(6 * static_cast<Eigen::Index>(edge.from)) += weighted * residual;
  all.gradient.segment<6>(6 * static_cast<Eigen::Index>(edge.to)) += own * residual;
}

void add_prior(const GraphPrior& prior, const std::vector<Pose>& poses, Equations& all) {
  const Pose& pose = poses[prior.pose];
  Vector6d residual;
  residual << pose.translation() - prior.T_map_pose.translation(),
      rotation_vector(pose.linear() * prior.T_map_pose.linear().transpose());
  Vector6d information = information_of(prior.sigma_m, prior.sigma_rad);
  information *= huber(std::sqrt(residual.dot(information.cwiseProduct(residual))));
  const Matrix6d own = information.asDiagonal();
  add_block(prior.pose, prior.pose, own, all);
  all.gradient.segment<6>(6 * static_cast<Eigen::Index>(prior.pose)) += own * residual;
}

// Removes poses from the equations: their terms with others are dropped, and each stays where it
// is. Their terms for the poses of others are in the others' own blocks.
void hold(const std::vector<std::uint32_t>& poses, Equations& all) {
  if (poses.empty()) return;
  std::vector<bool> is_held(static_cast<std::size_t>(all.gradient.size() / 6), false);
  for (const std::uint32_t pose : poses) is_held[pose] = true;
  std::erase_if(all.blocks, [&](const auto& block) {
    return is_held[block.first.first] || is_held[block.first.second];
  });
  const Vector6d information = information_of(kFixed_m, kFixed_rad);
  for (const std::uint32_t pose : poses) {
    all.blocks[{pose, pose}] = information.asDiagonal();
    all.gradient.segment<6>(6 * static_cast<Eigen::Index>(pose)).setZero();
  }
}

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

void add_block(std::uint32_t row, std::uint32_t column, const Matrix6d& block, Equations& all) {
  const auto [place, is_new] = all.blocks.try_emplace({row, column}, block);
  if (!is_new) place->second += block;
}

void add_graph(const PoseGraph& graph, const std::vector<Pose>& poses, Equations& all) {
  for (const GraphEdge& edge : graph.odometry) add_edge(edge, poses, all);
  for (const GraphEdge& edge : graph.loops) add_edge(edge, poses, all);
  for (const GraphPrior& prior : graph.priors) add_prior(prior, poses, all);
  if (graph.priors.empty()) add_prior({0, poses[0], kFixed_m, kFixed_rad}, poses, all);
  hold(graph.held, all);
}

std::map<BlockKey, Matrix6d> blocks_below_graph(const PoseGraph& graph,
                                                const std::vector<Pose>& poses,
                                                const Equations& all) {
  Equations of_graph{{}, Eigen::VectorXd::Zero(all.gradient.size())};
  add_graph(graph, poses, of_graph);
  for (auto& [key, block] : of_graph.blocks) {
    const auto below = all.blocks.find(key);
    block = below == all.blocks.end() ? Matrix6d::Zero() : below->second;
  }
  return std::move(of_graph.blocks);
}

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
