#include "passes/model/forest/support.h"

#include <algorithm>

#include "formats/base/parallel.h"

namespace sightline {

Support::Support(const ErrorModel& model, double margin) : model_(model), margin_(margin) {
  for (const FeatureCard& feature : model.features) {
    const bool is_range = &feature == &model.features.back();
    weights_.push_back(is_range ? 0.0 : std::max(0.0, feature.importance_m));
  }
  const double total = ordered_sum(weights_);
  if (total <= 0.0) return;
  for (double& weight : weights_) weight /= total;
}

double Support::outside_share(const float* row, std::size_t range) const {
  double share = 0.0;
  for (std::size_t i = 0; i < weights_.size(); ++i) {
    const double least = model_.features[i].support_min[range];
    const double greatest = model_.features[i].support_max[range];
    const double slack = margin_ * (greatest - least);
    const double value = row[i];
    if (value < least - slack || value > greatest + slack) share += weights_[i];
  }
  return share;
}

bool Support::is_outside(const float* row, std::size_t range) const {
  constexpr double kMostOutside = 0.5;
  return outside_share(row, range) > kMostOutside;
}

}  // namespace sightline
