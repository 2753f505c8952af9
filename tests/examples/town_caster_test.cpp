#include "examples/town/drive/caster.h"

#include <gtest/gtest.h>

#include <cmath>

#include "examples/town/whole/town.h"
#include "formats/base/random.h"
#include "tests/support/value_of.h"

namespace sightline::town {
namespace {

// Moeller and Trumbore (1997), in double, every triangle in turn.
double brute_force_range_m(const TownMesh& mesh, const Eigen::Vector3d& origin_m,
                           const Eigen::Vector3d& ray) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const std::array<std::uint32_t, 3>& triangle : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices_m[triangle[0]].cast<double>();
    const Eigen::Vector3d ab = mesh.vertices_m[triangle[1]].cast<double>() - a;
    const Eigen::Vector3d ac = mesh.vertices_m[triangle[2]].cast<double>() - a;
    const Eigen::Vector3d p = ray.cross(ac);
    const double determinant = ab.dot(p);
    if (determinant == 0.0) continue;
    const Eigen::Vector3d offset = origin_m - a;
    const double u = offset.dot(p) / determinant;
    const Eigen::Vector3d q = offset.cross(ab);
    const double v = ray.dot(q) / determinant;
    const double range_m = ac.dot(q) / determinant;
    if (u < 0.0 || v < 0.0 || u + v > 1.0 || range_m < 0.0) continue;
    nearest = std::min(nearest, range_m);
  }
  return nearest;
}

TEST(TownCaster, MeasuresToTheNearFaceOfABoxAndNothingBesideIt) {
  TownMesh mesh;
  // Quarters and halves, so that the expected numbers are exact in float.
  add_box(mesh, {Eigen::Vector2d(10.5, 0.0), 0.0, 1.0, 2.0, 0.0, 2.0}, Label::kPole);
  const TownCaster caster(mesh);
  const Eigen::Vector3d origin(0.0, 0.25, 1.0);
  const Hit hit = caster.cast(origin, Eigen::Vector3d::UnitX());
  EXPECT_DOUBLE_EQ(hit.range_m, 10.0);
  EXPECT_DOUBLE_EQ(hit.cosine, 1.0);
  EXPECT_EQ(hit.label, Label::kPole);
  EXPECT_FALSE(caster.cast(origin, Eigen::Vector3d::UnitY()).is_hit());
  EXPECT_FALSE(std::isfinite(caster.exact_range_m(origin, -Eigen::Vector3d::UnitX())));
}

TEST(TownCaster, AgreesWithEveryTriangleTriedInTurn) {
  const TownMesh mesh = standing_mesh(value_of(make_town({5, 20.0})), 0);
  const TownCaster caster(mesh);
  Random random(1);
  int agreeing = 0;
  constexpr int kRays = 120;
  for (int i = 0; i < kRays; ++i) {
    const Eigen::Vector3d origin(random.uniform(0.0, 20.0), random.uniform(-1.0, 1.0), 1.8);
    const double azimuth = random.uniform(0.0, 2.0 * std::numbers::pi);
    const double elevation = random.uniform(-0.26, 0.26);
    const Eigen::Vector3d ray(std::cos(elevation) * std::cos(azimuth),
                              std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
    const double expected_m = brute_force_range_m(mesh, origin, ray);
    const double found_m = caster.exact_range_m(origin, ray);
    if (found_m == expected_m || std::abs(found_m - expected_m) < 1e-9) ++agreeing;
  }
  EXPECT_EQ(agreeing, kRays);
}

// Rays at the very corners of triangles, where floats would decide by chance.
TEST(TownCaster, AgreesWithEveryTriangleAtTheirCorners) {
  const TownMesh mesh = standing_mesh(value_of(make_town({5, 20.0})), 0);
  const TownCaster caster(mesh);
  const Eigen::Vector3d origin_m(10.1, 0.3, 1.8);
  for (std::size_t i = 0; i < mesh.vertices_m.size(); i += mesh.vertices_m.size() / 100) {
    const Eigen::Vector3d ray = (mesh.vertices_m[i].cast<double>() - origin_m).normalized();
    const double expected_m = brute_force_range_m(mesh, origin_m, ray);
    const double found_m = caster.exact_range_m(origin_m, ray);
    EXPECT_TRUE(found_m == expected_m || std::abs(found_m - expected_m) < 1e-9)
        << i << ": " << found_m << " instead of " << expected_m;
  }
}

TEST(TownCaster, AnEmptyMeshIsHitByNothing) {
  const TownCaster caster(TownMesh{});
  EXPECT_FALSE(caster.cast(Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX()).is_hit());
}

}  // namespace
}  // namespace sightline::town
