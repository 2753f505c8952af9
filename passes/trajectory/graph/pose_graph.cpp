#include "passes/trajectory/graph/pose_graph.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <array>
#include <cmath>

#include "formats/base/portable_math.h"

namespace sightline {
namespace {

// Two solvers work on pose graphs. Ceres solves the graph of all scans first, from poses that loops
// may move by metres: a trust region with damped steps. Planes (plane_adjustment.h) then refine key
// scans near that solution by our own normal equations (normal_equations.h), which contain the
// edges of the graph again. Ceres cannot take their place for two reasons. The terms of a tile are
// blocks from which points and planes are already eliminated; Ceres would evaluate millions of
// points in every trial step. And every pose needs a covariance, which follows from the Cholesky
// factor in the time of factoring; ceres::Covariance would need the Jacobian of all points. The own
// equations could solve the first graph too, but not with the same bits: every pose would change.
//
// Only parts of Ceres are used that give the same bits on every processor. Its own rotations and
// its Levenberg-Marquardt call the C library's sines and powers, and its default sparse solver an
// optimised BLAS that may choose kernels by processor. So rotations are our own, and the solver is
// Powell's dogleg with Eigen's sparse Cholesky.

// As Ceres holds it: position, unit quaternion w x y z.
struct PoseBlock {
  std::array<double, 3> position_m{};
  std::array<double, 4> rotation{};
};

PoseBlock to_block(const Pose& pose) {
  const Eigen::Quaterniond q(pose.linear());
  return {{pose.translation().x(), pose.translation().y(), pose.translation().z()},
          {q.w(), q.x(), q.y(), q.z()}};
}

Pose to_pose(const PoseBlock& block) {
  Pose pose = Pose::Identity();
  pose.linear() =
      Eigen::Quaterniond(block.rotation[0], block.rotation[1], block.rotation[2], block.rotation[3])
          .normalized()
          .toRotationMatrix();
  pose.translation() =
      Eigen::Vector3d(block.position_m[0], block.position_m[1], block.position_m[2]);
  return pose;
}

double arc_tangent(double y, double x) { return portable_atan2(y, x); }

template <int kCount>
ceres::Jet<double, kCount> arc_tangent(const ceres::Jet<double, kCount>& y,
                                       const ceres::Jet<double, kCount>& x) {
  const double square = x.a * x.a + y.a * y.a;
  return {portable_atan2(y.a, x.a), (x.a / square) * y.v - (y.a / square) * x.v};
}

// Axis times angle of a unit quaternion w x y z, at most pi long.
template <class T>
void rotation_vector(const T* rotation, T* vector) {
  const T square =
      rotation[1] * rotation[1] + rotation[2] * rotation[2] + rotation[3] * rotation[3];
  T angle_per_sine(2.0);  // of the half angle; of no angle the limit
  if (square > T(0.0)) {
    using std::sqrt;
    const T sine = sqrt(square);
    // q and -q are one rotation.
    const T angle =
        rotation[0] < T(0.0) ? arc_tangent(-sine, -rotation[0]) : arc_tangent(sine, rotation[0]);
    angle_per_sine = T(2.0) * angle / sine;
  }
  for (std::size_t i = 0; i < 3; ++i) vector[i] = angle_per_sine * rotation[i + 1];
}

// Unit quaternions w x y z and steps from them: the axis times the tangent of half the angle.
struct QuaternionSteps {
  template <class T>
  bool Plus(const T* rotation, const T* step, T* moved) const {
    using std::sqrt;
    const T scale =
        T(1.0) / sqrt(T(1.0) + step[0] * step[0] + step[1] * step[1] + step[2] * step[2]);
    const T turn[4] = {scale, scale * step[0], scale * step[1], scale * step[2]};
    ceres::QuaternionProduct(turn, rotation, moved);
    return true;
  }
  template <class T>
  bool Minus(const T* moved, const T* rotation, T* step) const {
    const T inverse[4] = {rotation[0], -rotation[1], -rotation[2], -rotation[3]};
    T turn[4];
    ceres::QuaternionProduct(moved, inverse, turn);
    for (std::size_t i = 0; i < 3; ++i) step[i] = turn[i + 1] / turn[0];
    return true;
  }
};

// Translation and rotation vector of T_found^-1 * T_expected, each over its sigma, where T_found is
// by the poses: T_from^-1 * T_to of an edge.
template <class T>
void weighted_difference(const T* rotation, const T* position_m, const PoseBlock& expected,
                         const double sigma_m, const double sigma_rad, T* residual) {
  const T q_expected_inverse[4] = {T(expected.rotation[0]), -T(expected.rotation[1]),
                                   -T(expected.rotation[2]), -T(expected.rotation[3])};
  T difference[4];
  ceres::QuaternionProduct(q_expected_inverse, rotation, difference);
  T angle_axis[3];
  rotation_vector(difference, angle_axis);
  for (std::size_t i = 0; i < 3; ++i) {
    residual[i] = (position_m[i] - T(expected.position_m[i])) / T(sigma_m);
    residual[i + 3] = angle_axis[i] / T(sigma_rad);
  }
}

// What a residual that is divided by the sigmas of its edge is to be multiplied with: the root of
// the information of both parts of its covariance. Identity without a second part.
Matrix6d root_weights(const GraphEdge& edge) {
  if (edge.more.isZero(0.0)) return Matrix6d::Identity();
  Vector6d sigmas;
  sigmas << Eigen::Vector3d::Constant(edge.sigma_m), Eigen::Vector3d::Constant(edge.sigma_rad);
  const Matrix6d in_sigmas =
      sigmas.cwiseInverse().asDiagonal() * edge.more * sigmas.cwiseInverse().asDiagonal();
  const Matrix6d information = (Matrix6d::Identity() + in_sigmas).inverse();
  const Matrix6d symmetric = 0.5 * (information + information.transpose());
  return symmetric.llt().matrixU();
}

struct EdgeCost {
  PoseBlock expected;
  double sigma_m;
  double sigma_rad;
  bool is_weighted;
  Matrix6d weights;  // root_weights

  template <class T>
  bool operator()(const T* p_from, const T* q_from, const T* p_to, const T* q_to,
                  T* residual) const {
    const T q_inverse[4] = {q_from[0], -q_from[1], -q_from[2], -q_from[3]};
    const T step[3] = {p_to[0] - p_from[0], p_to[1] - p_from[1], p_to[2] - p_from[2]};
    T position_m[3];
    T rotation[4];
    ceres::QuaternionRotatePoint(q_inverse, step, position_m);
    ceres::QuaternionProduct(q_inverse, q_to, rotation);
    weighted_difference(rotation, position_m, expected, sigma_m, sigma_rad, residual);
    if (!is_weighted) return true;
    T weighted[6];
    for (int row = 0; row < 6; ++row) {
      weighted[row] = T(0.0);
      for (int column = row; column < 6; ++column) {
        weighted[row] += T(weights(row, column)) * residual[column];
      }
    }
    for (int row = 0; row < 6; ++row) residual[row] = weighted[row];
    return true;
  }
};

struct PriorCost {
  PoseBlock expected;
  double sigma_m;
  double sigma_rad;

  template <class T>
  bool operator()(const T* position_m, const T* rotation, T* residual) const {
    weighted_difference(rotation, position_m, expected, sigma_m, sigma_rad, residual);
    return true;
  }
};

void add_edge(const GraphEdge& edge, bool is_doubted, std::vector<PoseBlock>& blocks,
              ceres::Problem& problem) {
  auto* cost = new ceres::AutoDiffCostFunction<EdgeCost, 6, 3, 4, 3, 4>(
      new EdgeCost{to_block(edge.T_from_to), edge.sigma_m, edge.sigma_rad, !edge.more.isZero(0.0),
                   root_weights(edge)});
  ceres::LossFunction* loss = is_doubted ? new ceres::HuberLoss(1.0) : nullptr;
  PoseBlock& from = blocks[edge.from];
  PoseBlock& to = blocks[edge.to];
  problem.AddResidualBlock(cost, loss, from.position_m.data(), from.rotation.data(),
                           to.position_m.data(), to.rotation.data());
}

void add_prior(const GraphPrior& prior, std::vector<PoseBlock>& blocks, ceres::Problem& problem) {
  auto* cost = new ceres::AutoDiffCostFunction<PriorCost, 6, 3, 4>(
      new PriorCost{to_block(prior.T_map_pose), prior.sigma_m, prior.sigma_rad});
  PoseBlock& block = blocks[prior.pose];
  problem.AddResidualBlock(cost, new ceres::HuberLoss(1.0), block.position_m.data(),
                           block.rotation.data());
}

void hold(PoseBlock& block, ceres::Problem& problem) {
  problem.SetParameterBlockConstant(block.position_m.data());
  problem.SetParameterBlockConstant(block.rotation.data());
}

ceres::Solver::Options solver_options() {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  options.trust_region_strategy_type = ceres::DOGLEG;
  options.num_threads = 1;
  options.max_num_iterations = 100;
  options.logging_type = ceres::SILENT;
  return options;
}

void measure_residuals(const PoseGraph& graph, GraphSolution& solution) {
  double sum_m2 = 0.0;
  double sum_rad2 = 0.0;
  for (const std::vector<GraphEdge>* edges : {&graph.odometry, &graph.loops}) {
    for (const GraphEdge& edge : *edges) {
      const Pose T_from_to =
          solution.T_map_pose[edge.from].inverse() * solution.T_map_pose[edge.to];
      const Pose difference = edge.T_from_to.inverse() * T_from_to;
      const double angle_rad = rotation_angle_rad(difference.linear());
      sum_m2 += difference.translation().squaredNorm();
      sum_rad2 += angle_rad * angle_rad;
    }
  }
  const auto count = static_cast<double>(graph.odometry.size() + graph.loops.size());
  if (count > 0.0) {
    solution.rms_translation_m = std::sqrt(sum_m2 / count);
    solution.rms_rotation_rad = std::sqrt(sum_rad2 / count);
  }
}

}  // namespace

Result<GraphSolution> solve_pose_graph(const PoseGraph& graph, const std::vector<Pose>& start) {
  std::vector<PoseBlock> blocks;
  for (const Pose& pose : start) blocks.push_back(to_block(pose));
  ceres::Problem problem;
  for (PoseBlock& block : blocks) {
    problem.AddParameterBlock(block.position_m.data(), 3);
    problem.AddParameterBlock(block.rotation.data(), 4,
                              new ceres::AutoDiffManifold<QuaternionSteps, 4, 3>());
  }
  for (const GraphEdge& edge : graph.odometry) add_edge(edge, false, blocks, problem);
  for (const GraphEdge& edge : graph.loops) add_edge(edge, true, blocks, problem);
  for (const GraphPrior& prior : graph.priors) add_prior(prior, blocks, problem);
  if (graph.priors.empty() && !blocks.empty()) hold(blocks[0], problem);
  for (const std::uint32_t pose : graph.held) hold(blocks[pose], problem);
  ceres::Solver::Summary summary;
  ceres::Solve(solver_options(), &problem, &summary);
  if (!summary.IsSolutionUsable()) {
    return Error{ErrorCode::kTrajectoryLost, "the pose graph has no solution: " + summary.message,
                 "", "pass estimate-trajectory"};
  }
  GraphSolution solution;
  for (const PoseBlock& block : blocks) solution.T_map_pose.push_back(to_pose(block));
  measure_residuals(graph, solution);
  return solution;
}

Trajectory solved_trajectory(const MapFrame& frame, const PoseGraph& graph,
                             const GraphSolution& solution) {
  Trajectory trajectory;
  trajectory.frame = frame;
  trajectory.odometry_edges = static_cast<std::uint32_t>(graph.odometry.size());
  trajectory.loop_edges = static_cast<std::uint32_t>(graph.loops.size());
  trajectory.prior_edges = static_cast<std::uint32_t>(graph.priors.size());
  trajectory.rms_translation_residual_m = solution.rms_translation_m;
  trajectory.rms_rotation_residual_rad = solution.rms_rotation_rad;
  return trajectory;
}

}  // namespace sightline
