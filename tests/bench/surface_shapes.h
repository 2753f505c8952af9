#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "formats/surroundings/ndt_map.h"

// Shapes that a cleaned point cloud could be turned into for rays, to compare them with what the
// product uses (passes/rays/surface_caster.h).

namespace sightline {

// A flat patch: a disc takes the shorter half side as its radius, a quadrangle both.
struct FlatPatch {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d half_u_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d half_v_m = Eigen::Vector3d::Zero();
};

struct SolidBox {
  Eigen::Vector3d low_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d high_m = Eigen::Vector3d::Zero();
};

// |unit_per_m (x - centre)| <= 1.
struct SolidEllipsoid {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d unit_per_m = Eigen::Matrix3d::Identity();
  Eigen::Vector3d reach_m = Eigen::Vector3d::Zero();  // half of the box around it
};

class ShapeScene {
 public:
  static std::unique_ptr<ShapeScene> of_discs(std::span<const FlatPatch> patches);
  static std::unique_ptr<ShapeScene> of_quadrangles(std::span<const FlatPatch> patches);
  static std::unique_ptr<ShapeScene> of_boxes(std::vector<SolidBox> boxes);
  static std::unique_ptr<ShapeScene> of_ellipsoids(std::vector<SolidEllipsoid> ellipsoids);
  ~ShapeScene();
  ShapeScene(const ShapeScene&) = delete;
  ShapeScene& operator=(const ShapeScene&) = delete;

  // Distance to the first hit between 0.5 and 50 m along each direction of unit length, +inf where
  // there is none.
  void cast(const Eigen::Vector3d& p_m, std::span<const Eigen::Vector3f> directions,
            std::span<float> distance_m) const;

 private:
  struct State;
  explicit ShapeScene(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace sightline
