#pragma once

#include "formats/base/random.h"
#include "passes/matching/match_score.h"

namespace sightline {

// A random symmetric matrix whose eigenvalues are `least` or more.
inline Matrix6d random_positive(Random& random, double least) {
  Matrix6d half;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) half(i, j) = random.normal();
  }
  Matrix6d positive = half * half.transpose();
  positive.diagonal().array() += least;
  return positive;
}

}  // namespace sightline
