#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "formats/drive/sensor_profile.h"
#include "formats/geometry.h"
#include "formats/surroundings/surface_points.h"
#include "tests/support/lane/mesh.h"

// A lane to measure depth images in: undulating ground; slanted house fronts with windows set back,
// passages under arches and overhanging roofs; fences of pickets, hedges, trees of many small
// leaves with gaps between their boughs; thin poles, signs, cars with curved bodies; gaps between
// houses and a crossing, through which one sees far.

namespace sightline::lane {

struct LaneOptions {
  std::uint64_t seed = 1;
  double length_m = 60.0;
  bool has_leaves = true;  // false: bare trees, no hedges
  double hills = 1.0;      // 0: flat ground, on which the sensor keeps its height
};

// A ball around boughs or a stretch of hedge: what lies in its shadow is seen through leaves.
struct LeafBall {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  double radius_m = 1.0;
};

struct Ground {
  double hills = 1.0;
  [[nodiscard]] double height_m(double x_m, double y_m) const;
};

struct Lane {
  Ground ground;
  Mesh mesh;
  std::vector<LeafBall> leaf_balls;
};

Lane make_lane(const LaneOptions& options);

// On the driven line, 2 m above the ground at a length of way, pitching with the ground.
Pose sensor_pose(const Ground& ground, double way_m);

struct Hit {
  double range_m = std::numeric_limits<double>::infinity();  // nothing hit
  Kind kind = Kind::kGround;
};

// Rays against the triangles of a lane, both faces counting; good to a tenth of a millimetre. Safe
// from several threads.
class Caster {
 public:
  explicit Caster(const Mesh& mesh);
  ~Caster();
  Caster(const Caster&) = delete;
  Caster& operator=(const Caster&) = delete;

  [[nodiscard]] Hit cast(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

struct DriveOptions {
  SensorProfile sensor;
  double length_m = 60.0;
  double spacing_m = 1.0;  // between scans
  double range_sigma_m = 0.02;
  std::uint64_t seed = 1;
  int threads = 1;
};

// What the sensor saw along the lane, at true poses, behind a store of its own: nothing moved.
SurfacePoints drive_along(const Lane& lane, const Caster& caster, const DriveOptions& options);

}  // namespace sightline::lane
