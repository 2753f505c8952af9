#pragma once

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <span>
#include <vector>

#include "formats/surroundings/ndt_map.h"
#include "formats/symmetric_eigen.h"

// Every factor once more, as plainly as its definition reads: no shells, no sharing, no look-up but
// std::map. The oracle of the fast ones; written from schemas/definitions.md alone.

namespace sightline::plain {

using NdByCell = std::map<CellKey, const Nd*>;

inline NdByCell by_cell(const NdtMap& map) {
  NdByCell cells;
  for (const Nd& nd : map.nds) cells[nd.key] = &nd;
  return cells;
}

inline std::vector<const Nd*> within(const NdtMap& map, const Eigen::Vector3d& p, double range_m) {
  std::vector<const Nd*> found;
  for (const Nd& nd : map.nds)
    if ((nd.mean_m - p).norm() <= range_m) found.push_back(&nd);
  return found;
}

inline int dimension(const Nd& nd) {
  const double s1 = std::sqrt(nd.eigenvalues_m2[0]);
  const double s2 = std::sqrt(nd.eigenvalues_m2[1]);
  const double s3 = std::sqrt(nd.eigenvalues_m2[2]);
  const std::vector<double> behaviour = {s1 - s2, s2 - s3, s3};
  return 1 +
         static_cast<int>(std::max_element(behaviour.begin(), behaviour.end()) - behaviour.begin());
}

inline double dimension_count(const std::vector<const Nd*>& nds, int which) {
  double count = 0.0;
  for (const Nd* nd : nds) count += dimension(*nd) == which ? 1.0 : 0.0;
  return count;
}

inline double entropy(const std::map<int, double>& weights) {
  double total = 0.0;
  for (const auto& [bin, weight] : weights) total += weight;
  double bits = 0.0;
  for (const auto& [bin, weight] : weights) {
    if (weight > 0.0) bits += weight / total * std::log2(total / weight);
  }
  return bits;
}

inline int normal_bin(Eigen::Vector3d n) {
  if (n.z() < 0.0) n = -n;
  if (n.z() >= 72.0 / 73.0) return 1000;
  const int band = static_cast<int>(std::floor(n.z() / (18.0 / 73.0)));
  double a = std::atan2(n.y(), n.x()) * 180.0 / std::numbers::pi;
  while (a < 0.0) a += 360.0;
  if (band > 0) return 100 * band + static_cast<int>(std::floor((a + 10.0) / 20.0)) % 18;
  while (a >= 180.0) a -= 180.0;
  return static_cast<int>(std::floor((a + 5.0) / 10.0)) % 18;
}

inline double normal_entropy(const std::vector<const Nd*>& nds) {
  std::map<int, double> histogram;
  for (const Nd* nd : nds) {
    if (dimension(*nd) == 2) histogram[normal_bin(nd->eigenvectors.col(2))] += 1.0;
  }
  return entropy(histogram);
}

inline double r_average(const std::vector<const Nd*>& nds, const Eigen::Vector3d& p,
                        double range_m) {
  if (nds.empty()) return range_m;
  double sum = 0.0;
  for (const Nd* nd : nds) sum += (nd->mean_m - p).norm();
  return sum / static_cast<double>(nds.size());
}

inline Eigen::Matrix3d regularised(const Nd& nd) {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 3; ++i) {
    const double lambda = std::max(nd.eigenvalues_m2[i], 0.01 * nd.eigenvalues_m2[0]);
    covariance += lambda * nd.eigenvectors.col(i) * nd.eigenvectors.col(i).transpose();
  }
  return covariance;
}

inline double gauss_d2(double cell_m) {
  const double o = 0.55;
  const double c1 = 10.0 * (1.0 - o);
  const double c2 = o / std::pow(cell_m, 3);
  const double d3 = -std::log(c2);
  const double d1 = -std::log(c1 + c2) - d3;
  return -2.0 * std::log((-std::log(c1 * std::exp(-0.5) + c2) - d3) / d1);
}

inline const Nd* nd_at(const NdByCell& cells, const Eigen::Vector3d& x, double cell_m) {
  const auto found = cells.find({static_cast<std::int32_t>(std::floor(x.x() / cell_m)),
                                 static_cast<std::int32_t>(std::floor(x.y() / cell_m)),
                                 static_cast<std::int32_t>(std::floor(x.z() / cell_m))});
  return found == cells.end() ? nullptr : found->second;
}

// S(v) of one sender, v = 0.25 (i, j, 0) m at [17 (j + 8) + i + 8].
inline std::vector<double> self_score(const Nd& sender, const NdByCell& cells, double cell_m) {
  std::vector<Eigen::Vector3d> samples = {sender.mean_m};
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector3d spread =
        std::sqrt(sender.eigenvalues_m2[axis]) * sender.eigenvectors.col(axis);
    samples.push_back(sender.mean_m + spread);
    samples.push_back(sender.mean_m - spread);
  }
  std::vector<double> score;
  const double d2 = gauss_d2(cell_m);
  for (int j = -8; j <= 8; ++j) {
    for (int i = -8; i <= 8; ++i) {
      double sum = 0.0;
      for (const Eigen::Vector3d& sample : samples) {
        const Eigen::Vector3d x = sample + Eigen::Vector3d(0.25 * i, 0.25 * j, 0.0);
        const Nd* nd = nd_at(cells, x, cell_m);
        if (nd == nullptr) continue;
        const Eigen::Vector3d d = x - nd->mean_m;
        sum += std::exp(-0.5 * d2 * d.dot(regularised(*nd).inverse() * d));
      }
      score.push_back(sum);
    }
  }
  return score;
}

inline double score_entropy(const std::vector<double>& score) {
  const double largest = *std::max_element(score.begin(), score.end());
  if (largest <= 0.0) return std::log2(289.0);
  std::map<int, double> weights;
  for (std::size_t v = 0; v < score.size(); ++v) {
    weights[static_cast<int>(v)] = std::exp(score[v] / (0.1 * largest));
  }
  return entropy(weights);
}

inline double flat_050(const std::vector<double>& score) {
  if (score[144] <= 0.0) return 1.0;
  double largest = 0.0;
  int count = 0;
  for (int j = -8; j <= 8; ++j) {
    for (int i = -8; i <= 8; ++i) {
      const double length_m = 0.25 * std::sqrt(static_cast<double>(i * i + j * j));
      if (length_m < 0.375 || length_m >= 0.625) continue;
      ++count;
      largest = std::max(largest, score[static_cast<std::size_t>(17 * (j + 8) + i + 8)]);
    }
  }
  return count == 12 ? largest / score[144] : std::numeric_limits<double>::quiet_NaN();
}

struct Bound {
  double max_m = 0.0;
  double min_m = 0.0;
  double heading_deg = 0.0;
  double yaw_rad = 0.0;
  double hz_lmin = 0.0;
  double points = 0.0;
};

// `points` are relative to p.
inline Bound bound(const NdByCell& cells, double cell_m, const Eigen::Vector3d& p,
                   std::span<const Eigen::Vector3d> points, double range_m) {
  using Matrix = Eigen::Matrix<double, 6, 6>;
  const double prior_angle = 10.0 * std::numbers::pi / 180.0;
  Matrix H = Matrix::Zero();
  for (int i = 0; i < 3; ++i) H(i, i) = 0.01;
  for (int i = 3; i < 6; ++i) H(i, i) = 1.0 / (prior_angle * prior_angle);
  Eigen::Matrix2d normals = Eigen::Matrix2d::Zero();
  Bound result;
  for (const Eigen::Vector3d& r : points) {
    if (r.norm() > range_m) continue;
    result.points += 1.0;
    const Nd* nd = nd_at(cells, p + r, cell_m);
    if (nd == nullptr) continue;
    Eigen::Matrix<double, 3, 6> J = Eigen::Matrix<double, 3, 6>::Zero();
    for (int i = 0; i < 3; ++i) {
      J.col(i) = Eigen::Vector3d::Unit(i);
      J.col(i + 3) = Eigen::Vector3d::Unit(i).cross(r);  // w cross (x - p)
    }
    H += J.transpose() * regularised(*nd).inverse() * J;
    if (dimension(*nd) != 2) continue;
    const Eigen::Vector2d n = nd->eigenvectors.col(2).head<2>();
    normals += n * n.transpose();
  }
  // The Schur complement onto x, y is the inverse of that part of H's inverse.
  const Matrix covariance = H.inverse();
  const SymmetricEigen<2> eigen = symmetric_eigen<2>(covariance.topLeftCorner<2, 2>());
  result.max_m = std::sqrt(eigen.values[1]);
  result.min_m = std::sqrt(eigen.values[0]);
  const Eigen::Vector2d weak = eigen.vectors.col(1);
  result.heading_deg =
      std::fmod(std::atan2(weak.y(), weak.x()) * 180.0 / std::numbers::pi + 360.0, 180.0);
  result.yaw_rad = std::sqrt(covariance(5, 5));
  result.hz_lmin = symmetric_eigen<2>(normals).values[0];
  return result;
}

}  // namespace sightline::plain
