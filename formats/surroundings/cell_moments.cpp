#include "formats/surroundings/cell_moments.h"

namespace sightline {

void CellMoments::add(const Eigen::Vector3d& from_centre_m, double sign) {
  count += sign;
  sum_m += sign * from_centre_m;
  products_m2 += sign * from_centre_m * from_centre_m.transpose();
}

void CellMoments::add(const CellMoments& other, double sign) {
  count += sign * other.count;
  sum_m += sign * other.sum_m;
  products_m2 += sign * other.products_m2;
}

void CellMoments::add(const Nd& nd, const Eigen::Vector3d& mean_from_centre_m) {
  const double n = nd.point_count;
  count += n;
  sum_m += n * mean_from_centre_m;
  products_m2 +=
      (n - 1.0) * nd.covariance_m2 + n * mean_from_centre_m * mean_from_centre_m.transpose();
}

// sum of (p + d)(p + d)^T = sum of p p^T + s d^T + d s^T + n d d^T.
CellMoments CellMoments::seen_from(const Eigen::Vector3d& centre_from_there_m) const {
  const Eigen::Vector3d& d = centre_from_there_m;
  const Eigen::Matrix3d mixed = sum_m * d.transpose();
  CellMoments there;
  there.count = count;
  there.sum_m = sum_m + count * d;
  there.products_m2 = products_m2 + mixed + mixed.transpose() + count * d * d.transpose();
  return there;
}

Eigen::Matrix3d CellMoments::covariance_m2() const {
  const Eigen::Vector3d mean = mean_m();
  return (products_m2 - count * mean * mean.transpose()) / (count - 1.0);
}

Nd undecomposed_nd(const CellKey& key, const CellMoments& moments, double cell_m) {
  Nd nd;
  nd.key = key;
  nd.point_count = static_cast<std::uint32_t>(moments.count);
  nd.mean_m = cell_centre_m(key, cell_m) + moments.mean_m();
  nd.covariance_m2 = moments.covariance_m2();
  return nd;
}

Nd nd_of(const CellKey& key, const CellMoments& moments, double cell_m) {
  Nd nd = undecomposed_nd(key, moments, cell_m);
  decompose(nd);
  return nd;
}

}  // namespace sightline
