#include "passes/matching/covariance/structure_information.h"

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <map>
#include <numbers>

#include "tests/passes/matching/allocation_counter.h"
#include "tests/passes/matching/random_scene.h"
#include "tests/support/box_world.h"

namespace sightline {
namespace {

const Pose kSensor = lidar_at(0.0, 0.0, 0.0);

std::vector<Eigen::Vector3d> noisy(std::vector<Eigen::Vector3d> points_m, std::uint64_t seed) {
  Random random(seed);
  for (Eigen::Vector3d& point_m : points_m) {
    point_m *= 1.0 + 0.02 * random.normal() / point_m.norm();
  }
  return points_m;
}

// In the vehicle's frame.
std::vector<Eigen::Vector3d> scan_at(const BoxWorld& world, const Pose& T_map_vehicle,
                                     std::uint64_t seed) {
  std::vector<Eigen::Vector3d> points_m =
      noisy(scan_world(world, T_map_vehicle * kSensor, 1.0).points_m, seed);
  for (Eigen::Vector3d& point_m : points_m) point_m = kSensor * point_m;
  return points_m;
}

// Points of scans 2 m apart along x, in the map frame.
std::vector<Eigen::Vector3d> mapped_points(const BoxWorld& world) {
  std::vector<Eigen::Vector3d> points_m;
  for (int k = -8; k <= 8; k += 2) {
    const Pose pose = pose_at(k, 0.0, 0.0);
    for (const Eigen::Vector3d& point_m : scan_at(world, pose, mix(3, static_cast<unsigned>(k)))) {
      points_m.push_back(pose * point_m);
    }
  }
  return points_m;
}

// No wall is on a face of a cell.
BoxWorld bare_walls() {
  return {{{{-200.0, 6.7, 0.0}, {200.0, 8.0, 6.0}}, {{-200.0, -8.0, 0.0}, {200.0, -6.7, 6.0}}}};
}

BoxWorld with_poles(BoxWorld world) {
  for (const double x_m : {-8.7, 3.3, 15.7}) {
    world.boxes.push_back({{x_m, 4.3, 0.0}, {x_m + 0.2, 4.5, 6.0}});
    world.boxes.push_back({{x_m + 2.0, -4.5, 0.0}, {x_m + 2.2, -4.3, 6.0}});
  }
  return world;
}

struct World {
  explicit World(const BoxWorld& boxes)
      : map(simple_map(mapped_points(boxes), 2.0)),
        structures(map),
        points_m(scan_at(boxes, T_map_vehicle, 99)) {}
  Pose T_map_vehicle = pose_at(0.4, 0.3, 0.05);
  NdtMap map;
  StructureMap structures;
  std::vector<Eigen::Vector3d> points_m;
};

StructureEvidence evidence_of(const World& world) {
  StructureObserver observer;
  return structure_evidence(world.structures, make_scan_for_match(world.points_m),
                            world.T_map_vehicle, observer);
}

// By the definition, cell by cell, in map axes; nothing reduced.
struct BruteForce {
  explicit BruteForce(const World& world) {
    for (const Nd& nd : world.map.nds) nds[nd.key] = &nd;
    for (const auto& [key, nd] : nds) {
      const double width_m = std::sqrt(nd->eigenvalues_m2[1]);
      const double depth_m = std::sqrt(nd->eigenvalues_m2[2]);
      const bool is_line = is_upright_line(*nd) && !is_end_of_wall(*nd);
      if (width_m >= 0.06 && width_m >= 3.0 * depth_m) {
        add(*nd, 2, 0.03 * 0.03, 0.25, world);
      } else if (is_line) {
        add(*nd, 1, 0.06 * 0.06, 0.25, world);
        add(*nd, 2, 0.06 * 0.06, 0.25, world);
      } else if (width_m >= 0.06 && width_m >= 1.5 * depth_m) {
        add(*nd, 2, 0.03 * 0.03 + depth_m * depth_m, std::max(0.25, 2.0 * depth_m), world);
      }
    }
  }

  [[nodiscard]] bool is_end_of_wall(const Nd& nd) const {
    for (const auto& [other, beside] : nds) {
      const bool is_near = std::abs(other.x - nd.key.x) <= 1 && std::abs(other.y - nd.key.y) <= 1 &&
                           other.z == nd.key.z && other != nd.key;
      if (is_near && ends_surface(nd, *beside)) return true;
    }
    return false;
  }

  void add(const Nd& nd, int axis, double shared_m2, double farthest_m, const World& world) {
    double count = 0.0;
    const Eigen::Vector3d direction = nd.eigenvectors.col(axis);
    Vector6d derivative = Vector6d::Zero();
    double residual_m = 0.0;
    const std::size_t stride = 1 + world.points_m.size() / 512;
    for (std::size_t i = 0; i < world.points_m.size(); i += stride) {
      const Eigen::Vector3d at_m = world.T_map_vehicle * world.points_m[i];
      if (cell_key(at_m, 2.0) != nd.key) continue;
      if (std::abs(nd.eigenvectors.col(2).dot(at_m - nd.mean_m)) > farthest_m) continue;
      const Eigen::Vector3d arm_m = at_m - world.T_map_vehicle.translation();
      Vector6d of_point;
      of_point << direction, arm_m.cross(direction);
      derivative += of_point;
      residual_m += direction.dot(at_m - nd.mean_m);
      count += 1.0;
    }
    if (count == 0.0) return;
    derivative /= count;
    residual_m /= count;
    const double variance_m2 = shared_m2 + (nd.eigenvalues_m2[axis] + 0.02 * 0.02) / count;
    information += derivative * derivative.transpose() / variance_m2;
    descent -= derivative * residual_m / variance_m2;
    derivatives.push_back(derivative);
    variances_m2.push_back(variance_m2);
  }

  std::map<CellKey, const Nd*> nds;
  Matrix6d information = Matrix6d::Zero();
  Vector6d descent = Vector6d::Zero();
  std::vector<Vector6d> derivatives;
  std::vector<double> variances_m2;
};

// Of x, y and yaw, in units of 1 m and 0.1 rad; heights are known to 1 m and tilts to 0.1 rad.
Eigen::Matrix3d planar_part(const Matrix6d& information) {
  Matrix6d known = information;
  known.diagonal() += (Vector6d() << 0.0, 0.0, 1.0, 100.0, 100.0, 0.0).finished();
  const Matrix6d covariance = known.inverse();
  Eigen::Matrix3d planar;
  const int places[] = {0, 1, 5};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const double scale = (i == 2 ? 10.0 : 1.0) * (j == 2 ? 10.0 : 1.0);
      planar(i, j) = scale * covariance(places[i], places[j]);
    }
  }
  return planar.inverse();
}

TEST(StructureInformation, OfAStreetIsTheSumOverItsCells) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const World world(random_street(seed));
    const BruteForce expected(world);
    const StructureEvidence found = evidence_of(world);
    EXPECT_GT(expected.derivatives.size(), 40u);
    // What the limit on small components takes away of a street is little.
    EXPECT_LT((found.information - expected.information).norm(), 0.1 * expected.information.norm());
    EXPECT_LT((found.descent - expected.descent).norm(), 0.1 * expected.descent.norm() + 10.0);
  }
}

TEST(StructureInformation, IsReducedAlongEachMotionToWhatClearlyHoldsIt) {
  for (const BoxWorld& boxes :
       {random_street(4), bare_walls(), with_poles({}), with_poles(bare_walls())}) {
    const World world(boxes);
    const BruteForce whole(world);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(planar_part(whole.information));
    Eigen::Matrix3d expected = Eigen::Matrix3d::Zero();
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d motion = eigen.eigenvectors().col(i);
      double clear = 0.0;
      for (std::size_t k = 0; k < whole.derivatives.size(); ++k) {
        const Vector6d& by = whole.derivatives[k];
        const double part = Eigen::Vector3d(by[0], by[1], by[5] / 10.0).dot(motion);
        const double least = 0.17 * std::max(1.0, by.tail<3>().norm() / 10.0);
        if (std::abs(part) >= least) clear += part * part / whole.variances_m2[k];
      }
      const double value = std::min(clear, eigen.eigenvalues()[i]);
      expected += value * motion * motion.transpose();
    }
    const Eigen::Matrix3d found = planar_part(evidence_of(world).information);
    // But for what is known of heights and tilts.
    EXPECT_LT((found - expected).norm(), 1e-4 * expected.norm() + 1e-6) << found << "\n\n"
                                                                        << expected;
  }
}

TEST(StructureInformation, IsNeverBelowNothing) {
  for (const BoxWorld& boxes : {BoxWorld{}, bare_walls(), with_poles({}), random_street(5)}) {
    const StructureEvidence found = evidence_of(World(boxes));
    EXPECT_EQ(found.information, found.information.transpose());
    const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(found.information);
    EXPECT_GT(eigen.eigenvalues()[0], -1e-9 * eigen.eigenvalues()[5]);
  }
}

TEST(StructureInformation, AlongBareWallsIsNothing) {
  const Eigen::Matrix3d found = planar_part(evidence_of(World(bare_walls())).information);
  EXPECT_LT(found(0, 0), 1.0);  // 1 m
  EXPECT_GT(found(1, 1), 1e4);  // 1 cm
  EXPECT_GT(found(2, 2), 1e4);
  const World poles(with_poles(bare_walls()));
  EXPECT_GT(planar_part(evidence_of(poles).information)(0, 0), 400.0);  // 5 cm
}

TEST(StructureInformation, TurnsWithMapAndVehicle) {
  const World world(with_poles(random_street(6)));
  const Pose quarter = pose_at(0.0, 0.0, 0.5 * std::numbers::pi);
  World turned = world;
  std::vector<Eigen::Vector3d> mapped_m = mapped_points(with_poles(random_street(6)));
  for (Eigen::Vector3d& point_m : mapped_m) point_m = quarter * point_m;
  turned.map = simple_map(mapped_m, 2.0);
  turned.structures = StructureMap(turned.map);
  turned.T_map_vehicle = quarter * world.T_map_vehicle;
  Matrix6d rotation = Matrix6d::Zero();
  rotation.topLeftCorner<3, 3>() = rotation.bottomRightCorner<3, 3>() = quarter.linear();
  const StructureEvidence before = evidence_of(world);
  const StructureEvidence after = evidence_of(turned);
  const Matrix6d expected = rotation * before.information * rotation.transpose();
  EXPECT_LT((after.information - expected).norm(), 1e-6 * expected.norm());
  EXPECT_LT((after.descent - rotation * before.descent).norm(), 1e-6 * before.descent.norm());
}

TEST(StructureObserver, DerivativesAreThoseOfTheResiduals) {
  const World world(with_poles(random_street(7)));
  constexpr double kStep = 1e-6;
  const auto observe = [&](const Pose& T_map_vehicle, StructureObserver& observer) {
    observer.begin(world.structures, T_map_vehicle);
    for (const Eigen::Vector3d& point_m : world.points_m) {
      const CellKey cell = cell_key(world.T_map_vehicle * point_m, 2.0);  // wherever it moves
      const std::uint32_t number =
          world.structures.number_of_record(record_of_cell(world.structures.grid(), cell));
      if (StructureMap::is_structure(number)) observer.add(number, T_map_vehicle * point_m);
    }
    return observer.finish();
  };
  StructureObserver at, before, after;
  const std::span<const StructureObservation> here = observe(world.T_map_vehicle, at);
  for (int i = 0; i < 6; ++i) {
    Vector6d motion = Vector6d::Zero();
    motion.segment<3>(i < 3 ? 0 : 3) = at.axes().row(i % 3).transpose() * kStep;
    const auto high = observe(moved(world.T_map_vehicle, motion), after);
    const auto low = observe(moved(world.T_map_vehicle, -motion), before);
    ASSERT_EQ(high.size(), here.size());
    ASSERT_EQ(low.size(), here.size());
    for (std::size_t k = 0; k < here.size(); ++k) {
      const double slope = (high[k].residual_m - low[k].residual_m) / (2.0 * kStep);
      EXPECT_NEAR(slope, here[k].by_motion[i], 1e-4) << k;
    }
  }
}

TEST(StructureInformation, IsTheSameFromTheMatchersCells) {
  const World world(with_poles(random_street(9)));
  const MatchGrid& grid = world.structures.grid();
  ScanForMatch scan = make_scan_for_match(world.points_m);
  for (const double off_m : {0.0, 0.3, 2.5}) {
    Pose elsewhere = world.T_map_vehicle;
    elsewhere.translation().x() += off_m;
    kernel_score(grid, scan, elsewhere, MatchKernel::kFastest);
    ASSERT_EQ(scan.cells_digest, grid.cells_digest);
    StructureObserver observer;
    const StructureEvidence found =
        structure_evidence(world.structures, scan, world.T_map_vehicle, observer);
    EXPECT_EQ(found.information, evidence_of(world).information);
    EXPECT_EQ(found.descent, evidence_of(world).descent);
  }
}

RaisedPoints raised_at(const World& world, double left_m) {
  Pose T_map_vehicle = world.T_map_vehicle;
  T_map_vehicle.translation() += left_m * T_map_vehicle.linear().col(1);
  StructureObserver observer;
  return structure_evidence(world.structures, make_scan_for_match(world.points_m), T_map_vehicle,
                            observer)
      .raised;
}

TEST(RaisedPoints, AreMetWhereTheVehicleIsAndNotAside) {
  const World walls(with_poles(bare_walls()));
  const RaisedPoints here = raised_at(walls, 0.0);
  EXPECT_GT(here.met_count, 100U);
  EXPECT_GE(here.met_count, 0.9 * here.count);
  EXPECT_LT(raised_at(walls, 3.0).met_count, 0.3 * raised_at(walls, 3.0).count);
  const RaisedPoints of_poles = raised_at(World(with_poles({})), 0.0);
  const RaisedPoints beside_poles = raised_at(World(with_poles({})), 5.0);
  EXPECT_LT(beside_poles.met_count, 0.5 * of_poles.met_count);
  const World ground(BoxWorld{});
  EXPECT_LT(raised_at(ground, 0.0).count, 26U) << "of 512: where the map has no ground either";
  EXPECT_EQ(raised_at(ground, 0.0).met_count, 0U);
}

TEST(StructureInformation, AllocatesNothingForScansOfASizeThatWasSeen) {
  const World world(random_street(8));
  const ScanForMatch scan = make_scan_for_match(world.points_m);
  StructureObserver observer;
  const auto find = [&] {
    return structure_evidence(world.structures, scan, world.T_map_vehicle, observer);
  };
  const StructureEvidence first = find();
  const std::size_t before = allocation_count();
  const StructureEvidence second = find();
  EXPECT_EQ(allocation_count(), before);
  EXPECT_EQ(first.information, second.information);
}

}  // namespace
}  // namespace sightline
