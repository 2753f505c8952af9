#include "passes/trajectory/graph/planes.h"

#include <Eigen/LU>
#include <algorithm>

#include "formats/grid/cell_index.h"
#include "formats/symmetric_eigen.h"

// A plane is n.(x - c) = d + a u.(x - c) + b v.(x - c) about the cell's mean c, with n, u, v its
// principal axes and d, a, b small. A point's residual r and its derivatives by the pose (J) and by
// d, a, b (A) are linear in q = [1, x - centre], so sums over a scan's points need only its 4 x 4
// moments S = sum q q^T: H = L S L^T, B = L S Q^T, C = Q S Q^T, where J^T = L q and A^T = Q q.

namespace sightline {
namespace {

constexpr double kCell_m = 1.0;
// Thickness of a plane's points, by its roughness and by errors of poses.
constexpr double kThickest_m = 0.08;
// Ratio of the smallest to the middle eigenvalue: less is a plane.
constexpr double kFlattest = 0.05;
// Middle eigenvalue: narrower things are poles, kerbs or reveals of windows.
constexpr double kNarrowest_m2 = 0.02;
constexpr double kLeastPoints = 10.0;
// Range noise and roughness of streets: no plane is more accurate.
constexpr double kNoise_m = 0.02;
// Points of one scan in one cell share their errors: together they count as so many.
constexpr double kMostOfAScan = 10.0;
// A scan whose points are this far off hit something else (Cauchy's weight).
constexpr double kDoubted_m = 0.05;

using Moments = Eigen::Matrix4d;
using Matrix64 = Eigen::Matrix<double, 6, 4>;
using Matrix63 = Eigen::Matrix<double, 6, 3>;
using Matrix34 = Eigen::Matrix<double, 3, 4>;

struct Member {
  std::uint32_t scan = 0;
  Moments moments = Moments::Zero();  // of [1, x - centre], map axes
};
struct SeenCell {
  CellKey key;
  std::vector<Member> members;  // ascending by scan
};

// Cells in the order of scans and their points.
std::vector<SeenCell> collect(std::span<const PlaneScan> scans, const Eigen::Vector2d& low_m,
                              const Eigen::Vector2d& high_m) {
  std::vector<SeenCell> cells;
  CellIndex index;
  for (std::uint32_t s = 0; s < scans.size(); ++s) {
    for (const Eigen::Vector3f& point_m : *scans[s].points_m) {
      const Eigen::Vector3d at_m = scans[s].T_map_lidar * point_m.cast<double>();
      if (at_m.x() < low_m.x() || at_m.x() >= high_m.x() || at_m.y() < low_m.y() ||
          at_m.y() >= high_m.y()) {
        continue;
      }
      const CellKey key = cell_key(at_m, kCell_m);
      const std::uint32_t number = index.add(key);
      if (number == cells.size()) cells.push_back({key, {}});
      SeenCell& cell = cells[number];
      if (cell.members.empty() || cell.members.back().scan != s) cell.members.push_back({s});
      Eigen::Vector4d q;
      q << 1.0, at_m - cell_centre_m(key, kCell_m);
      cell.members.back().moments.noalias() += q * q.transpose();
    }
  }
  return cells;
}

struct Plane {
  bool is_plane = false;
  Eigen::Vector3d mean_m = Eigen::Vector3d::Zero();    // from the cell's centre
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  // n, u, v
  double variance_m2 = 0.0;                            // across
};

Plane plane_of(const Moments& sum) {
  Plane plane;
  const double count = sum(0, 0);
  if (count < kLeastPoints) return plane;
  plane.mean_m = sum.block<3, 1>(1, 0) / count;
  const Eigen::Matrix3d covariance_m2 =
      sum.block<3, 3>(1, 1) / count - plane.mean_m * plane.mean_m.transpose();
  const SymmetricEigen<3> eigen = symmetric_eigen<3>(covariance_m2);
  plane.axes = eigen.vectors;
  plane.variance_m2 = std::max(eigen.values[0], 0.0);
  plane.is_plane = plane.variance_m2 <= kThickest_m * kThickest_m &&
                   plane.variance_m2 <= kFlattest * eigen.values[1] &&
                   eigen.values[1] >= kNarrowest_m2;
  return plane;
}

// J^T = L q for a scan whose sensor is at `origin_m` from the cell's centre.
Matrix64 motion_map(const Eigen::Vector3d& n, const Eigen::Vector3d& origin_m) {
  Eigen::Matrix3d cross;
  cross << 0.0, -n.z(), n.y(), n.z(), 0.0, -n.x(), -n.y(), n.x(), 0.0;
  Matrix64 map = Matrix64::Zero();
  map.block<3, 1>(0, 0) = n;
  map.block<3, 1>(3, 0) = cross * origin_m;  // (x - origin) x n
  map.block<3, 3>(3, 1) = -cross;
  return map;
}

// Of a scan that is not held.
struct Term {
  std::uint32_t scan = 0;
  Matrix63 to_plane = Matrix63::Zero();  // B
};

// Keeps only the scans on the side of the plane with most points: those on the other side hit the
// back of the thing. Taken as one plane, both would pull the way before it and the way after it
// together.
void keep_one_side(const Eigen::Vector3d& n, std::span<const PlaneScan> scans, SeenCell& cell) {
  const auto is_ahead = [&](const Member& member) {
    const Eigen::Vector3d seen_m = member.moments.block<3, 1>(1, 0) / member.moments(0, 0);
    const Eigen::Vector3d origin_m =
        scans[member.scan].T_map_lidar.translation() - cell_centre_m(cell.key, kCell_m);
    return n.dot(origin_m - seen_m) >= 0.0;
  };
  double balance = 0.0;
  for (const Member& member : cell.members) {
    balance += is_ahead(member) ? member.moments(0, 0) : -member.moments(0, 0);
  }
  std::erase_if(cell.members,
                [&](const Member& member) { return is_ahead(member) != (balance >= 0.0); });
}

Moments sum_of(const SeenCell& cell) {
  Moments sum = Moments::Zero();
  for (const Member& member : cell.members) sum += member.moments;
  return sum;
}

// Whether a cell constrains a pose that is not held.
bool constrains(const SeenCell& cell, std::span<const PlaneScan> scans) {
  return cell.members.size() >= 2 && std::ranges::any_of(cell.members, [&](const Member& member) {
           return !scans[member.scan].is_held;
         });
}

void add_cell(SeenCell cell, std::span<const PlaneScan> scans, PlaneEquations& equations) {
  if (!constrains(cell, scans)) return;
  keep_one_side(plane_of(sum_of(cell)).axes.col(0), scans, cell);
  if (!constrains(cell, scans)) return;
  const Plane plane = plane_of(sum_of(cell));
  if (!plane.is_plane) return;
  const Eigen::Vector3d n = plane.axes.col(0);
  Eigen::Vector4d residual;
  residual << -n.dot(plane.mean_m), n;
  Matrix34 unknowns = Matrix34::Zero();  // Q
  unknowns(0, 0) = -1.0;
  for (int i = 1; i <= 2; ++i) {
    unknowns(i, 0) = plane.axes.col(i).dot(plane.mean_m);
    unknowns.block<1, 3>(i, 1) = -plane.axes.col(i).transpose();
  }
  const double weight = 1.0 / (plane.variance_m2 + kNoise_m * kNoise_m);
  Eigen::Matrix3d of_plane = Eigen::Matrix3d::Zero();  // C
  Eigen::Vector3d gradient_of_plane = Eigen::Vector3d::Zero();
  std::vector<Term> terms;
  terms.reserve(cell.members.size());
  for (const Member& member : cell.members) {
    const double count = member.moments(0, 0);
    const double off_m = residual.dot(member.moments.col(0)) / count;
    const double trust = 1.0 / (1.0 + off_m * off_m / (kDoubted_m * kDoubted_m));
    const double scale = trust * weight * std::min(1.0, kMostOfAScan / count);
    const Moments moments = scale * member.moments;
    const Pose& T_map_lidar = scans[member.scan].T_map_lidar;
    const Matrix64 motion =
        motion_map(n, T_map_lidar.translation() - cell_centre_m(cell.key, kCell_m));
    const Matrix64 weighted = motion * moments;
    if (!scans[member.scan].is_held) {
      const Eigen::Index row = 6 * static_cast<Eigen::Index>(member.scan);
      equations.hessian.block<6, 6>(row, row) += weighted * motion.transpose();
      equations.gradient.segment<6>(row) += weighted * residual;
      terms.push_back({member.scan, weighted * unknowns.transpose()});
    }
    of_plane += unknowns * moments * unknowns.transpose();
    gradient_of_plane += unknowns * moments * residual;
  }
  // If all points are on one line, the plane may turn about it.
  of_plane.diagonal().array() += 1e-6 * of_plane.diagonal().maxCoeff();
  const Eigen::Matrix3d inverse = of_plane.inverse();
  const Eigen::Vector3d shift = inverse * gradient_of_plane;
  for (const Term& a : terms) {
    const Eigen::Index row = 6 * static_cast<Eigen::Index>(a.scan);
    const Matrix63 left = a.to_plane * inverse;
    equations.gradient.segment<6>(row) -= a.to_plane * shift;
    for (const Term& b : terms) {
      if (b.scan > a.scan) break;
      const Eigen::Index column = 6 * static_cast<Eigen::Index>(b.scan);
      equations.hessian.block<6, 6>(row, column).noalias() -= left * b.to_plane.transpose();
    }
  }
}

}  // namespace

PlaneEquations plane_equations(std::span<const PlaneScan> scans, const Eigen::Vector2d& low_m,
                               const Eigen::Vector2d& high_m) {
  PlaneEquations equations;
  const auto size = static_cast<Eigen::Index>(6 * scans.size());
  equations.hessian = Eigen::MatrixXd::Zero(size, size);
  equations.gradient = Eigen::VectorXd::Zero(size);
  for (const SeenCell& cell : collect(scans, low_m, high_m)) add_cell(cell, scans, equations);
  return equations;
}

}  // namespace sightline
