#include "passes/factors/paper/feature_count.h"

namespace sightline {

std::vector<double> feature_count(const Vicinity& vicinity) {
  return {vicinity.end.begin(), vicinity.end.end()};
}

}  // namespace sightline
