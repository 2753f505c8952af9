#pragma once

#include <cstdint>
#include <vector>

#include "examples/town/world/mesh.h"
#include "examples/town/world/plan.h"

// What stands in the streets of a town.

namespace sightline::town {

// The uneven ground, fine near the driven line and coarse beyond, out of everything's reach.
void add_ground(TownMesh& mesh, std::uint64_t seed, const TownPlan& plan);

// Kerbs, and the pavement from kerb to facade, 12 cm up; broken where another street crosses.
void add_pavements(TownMesh& mesh, std::uint64_t seed, const TownPlan& plan);

// Trees, poles, and what little stands on a plaza.
void add_furniture(TownMesh& mesh, std::uint64_t seed, const TownPlan& plan);

// A trunk and a crown of leaf-like triangles in an ellipsoid.
void add_tree(TownMesh& mesh, const Eigen::Vector2d& at_m, std::uint64_t seed);

enum class Vehicle { kCar, kVan };
struct Pose2d {
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
  double yaw_rad = 0.0;
};
// On its wheels at z = ground_m; its size and shape depend on the seed.
void add_vehicle(TownMesh& mesh, const Pose2d& pose, double ground_m, std::uint64_t seed,
                 Label label);
void add_pedestrian(TownMesh& mesh, const Pose2d& pose, double ground_m, std::uint64_t seed);

// A flat board on a pole, both faces bare: what somebody puts up where a street has too little to
// localize by. It stands on the ground at the pose's position and faces along its yaw.
struct Board {
  Pose2d pose;
  double width_m = 1.0;
  double height_m = 2.0;
  double bottom_m = 0.5;  // lower edge above the ground
};
void add_board(TownMesh& mesh, const Board& board, double ground_m);

// Cars along kerbs, half of the room taken. No two seeds park alike, not even in marked places:
// those would tell a matcher where it is.
std::vector<Pose2d> parked_cars(std::uint64_t seed, const TownPlan& plan);

}  // namespace sightline::town
