#include "formats/map/container/small_nds.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "formats/base/random.h"
#include "formats/map/layers.h"
#include "tests/formats/map/random_map.h"
#include "tests/support/value_of.h"

namespace sightline {
namespace {

Eigen::Matrix3d random_rotation(Random& random) {
  Eigen::Quaterniond q(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0),
                       random.uniform(-1.0, 1.0), random.uniform(0.1, 1.0));
  return q.normalized().toRotationMatrix();
}

// A wall, a pole, a bush: extents along three axes that point anywhere.
Nd random_nd(Random& random, double cell_m) {
  Nd nd;
  nd.key = {static_cast<std::int32_t>(random.below(2000)) - 1000,
            static_cast<std::int32_t>(random.below(2000)) - 1000,
            static_cast<std::int32_t>(random.below(10)) - 5};
  nd.point_count = static_cast<std::uint32_t>(2 + random.below(1U << random.below(30)));
  const Eigen::Vector3d sigma_m(random.uniform(0.1, 0.6), random.uniform(0.02, 0.6),
                                random.uniform(0.002, 0.3));
  const Eigen::Matrix3d axes = random_rotation(random);
  nd.covariance_m2 = axes * sigma_m.cwiseAbs2().asDiagonal() * axes.transpose();
  const Eigen::Vector3d corner_m = Eigen::Vector3d(nd.key.x, nd.key.y, nd.key.z) * cell_m;
  for (int axis = 0; axis < 3; ++axis) {
    nd.mean_m[axis] = corner_m[axis] + cell_m * random.uniform(0.001, 0.999);
  }
  return nd;
}

TEST(SmallNd, IsTheSameAgainWhenRoundedTwice) {
  Random random(3);
  for (int i = 0; i < 20000; ++i) {
    const double cell_m = i % 3 == 0 ? 2.0 : random.uniform(0.2, 5.0);
    const std::int32_t half_step = half_step_units(cell_m);
    const SmallNd small = nearest_small(row_of(random_nd(random, cell_m), cell_m), half_step);
    const NdRow row = expanded(small, half_step);
    const std::optional<SmallNd> again = small_of(row, half_step);
    ASSERT_TRUE(again) << i;
    EXPECT_EQ(expanded(*again, half_step), row) << i;
    // As it is read from a map and written again.
    const Nd nd = nd_of(row, {1, -2, 3}, cell_m);
    EXPECT_EQ(row_of(nd, cell_m), row) << i;
  }
}

TEST(SmallNd, IsNearWhatItRounds) {
  Random random(4);
  for (int i = 0; i < 5000; ++i) {
    const double cell_m = random.uniform(0.5, 4.0);
    const Nd nd = random_nd(random, cell_m);
    const Nd small = rounded_small(nd, cell_m);
    EXPECT_LE((small.mean_m - nd.mean_m).cwiseAbs().maxCoeff(), cell_m / 500.0);
    EXPECT_NEAR(small.point_count, nd.point_count, 0.126 * nd.point_count);
    // In any direction a standard deviation differs by a sixth at most, where the ND is not thinner
    // than a 31st of its longest extent, below which no match sees a difference.
    const Eigen::Matrix3d floor = Eigen::Matrix3d::Identity() * nd.covariance_m2.trace() * 0.003;
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix3d> ratio(
        small.covariance_m2 + floor, nd.covariance_m2 + floor);
    EXPECT_GT(ratio.eigenvalues().minCoeff(), 0.7) << i;
    EXPECT_LT(ratio.eigenvalues().maxCoeff(), 1.4) << i;
  }
}

TEST(SmallNd, KeepsExtremesFinite) {
  for (const float value : {0.0F, 1e-30F, 1e30F, -1.0F}) {
    NdRow row;
    row.point_count = 0xFFFFFFFFU;
    row.covariance_m2 = {value, value, -value, value, value, value};
    const NdRow rounded = expanded(nearest_small(row, 3), 3);
    for (const float entry : rounded.covariance_m2) EXPECT_TRUE(std::isfinite(entry)) << value;
    EXPECT_GT(rounded.point_count, 1U << 31);
  }
}

std::vector<std::byte> small_layer(std::uint64_t seed, std::uint64_t rows) {
  Random random(seed);
  const NdtLayout layout(rows);
  std::vector<std::byte> raw(layout.size);
  for (std::uint64_t row = 0; row < rows; ++row) {
    const Nd nd = rounded_small(random_nd(random, 2.0), 2.0);
    const std::array<std::int32_t, 3> key = {nd.key.x, nd.key.y, nd.key.z};
    for (std::size_t i = 0; i < 3; ++i) {
      std::memcpy(raw.data() + layout.column[i] + 4 * row, &key[i], 4);
    }
    store_nd_row(row_of(nd, 2.0), layout, row, raw);
  }
  return raw;
}

TEST(SmallNds, UnpackToTheSameBytes) {
  for (const std::uint64_t rows : {1U, 2U, 100U, 3000U}) {
    const std::vector<std::byte> raw = small_layer(rows, rows);
    const std::optional<std::vector<std::byte>> packed = pack_small_nds(raw, rows, 2.0);
    ASSERT_TRUE(packed);
    EXPECT_EQ(value_of(unpack_small_nds(*packed, rows, raw.size())), raw);
    if (rows == 3000U) {
      EXPECT_LT(packed->size(), 17 * rows);
    }
  }
}

TEST(SmallNds, AreNotPackedWhereOneIsNotSmall) {
  std::vector<std::byte> raw = small_layer(1, 50);
  raw[NdtLayout(50).column[7] + 4 * 20] ^= std::byte{1};  // the last bit of a variance
  EXPECT_FALSE(pack_small_nds(raw, 50, 2.0));
}

TEST(SmallNds, DamageIsRefusedOrGivesALayerOfTheSameSize) {
  const std::vector<std::byte> raw = small_layer(5, 40);
  const std::vector<std::byte> packed = *pack_small_nds(raw, 40, 2.0);
  Random random(6);
  for (int i = 0; i < 20000; ++i) {
    std::vector<std::byte> damaged = packed;
    damaged[random.below(damaged.size())] ^= static_cast<std::byte>(1 + random.below(255));
    if (i % 4 == 0) damaged.resize(random.below(damaged.size()));
    const Result<std::vector<std::byte>> found = unpack_small_nds(damaged, 40, raw.size());
    if (found) {
      EXPECT_EQ(found->size(), raw.size());
    }
  }
  EXPECT_FALSE(unpack_small_nds(packed, 41, NdtLayout(41).size));
  EXPECT_FALSE(unpack_small_nds(packed, 40, raw.size() + 64));
}

}  // namespace
}  // namespace sightline
