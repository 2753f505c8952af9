#include "passes/trajectory/graph/normal_equations.h"

#include <Eigen/Geometry>
#include <cmath>
#include <utility>

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

}  // namespace sightline
