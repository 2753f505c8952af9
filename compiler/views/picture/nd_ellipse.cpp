#include "compiler/views/picture/nd_ellipse.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "formats/symmetric_eigen.h"

namespace sightline {
namespace {

constexpr double kSigmas = 2.0;
constexpr double kLeastRadius_m = 0.05;

}  // namespace

NdEllipse ellipse_from_above(const Nd& nd) {
  const SymmetricEigen<2> eigen = symmetric_eigen<2>(nd.covariance_m2.topLeftCorner<2, 2>());
  const auto radius_m = [&](int i) {
    return std::max(kLeastRadius_m, kSigmas * std::sqrt(std::max(0.0, eigen.values[i])));
  };
  NdEllipse ellipse;
  ellipse.centre_m = nd.mean_m.head<2>();
  ellipse.long_axis = eigen.vectors.col(1);
  ellipse.long_radius_m = radius_m(1);
  ellipse.short_radius_m = radius_m(0);
  return ellipse;
}

bool is_lying_plane(const Nd& nd) {
  return dimension_class(nd) == 2 && std::abs(nd.eigenvectors(2, 2)) > std::numbers::sqrt2 / 2.0;
}

}  // namespace sightline
