#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "formats/base/bytes.h"
#include "formats/base/result.h"
#include "formats/record/fields.h"
#include "formats/text/table.h"

// Poses, frames, how they are written, and rotations.

namespace sightline {

// `T_a_b` takes coordinates in frame b to coordinates in frame a.
using Pose = Eigen::Isometry3d;

// The map frame: world coordinates (the recording's own: UTM, first scan, ...) minus an origin
// that is a multiple of the tile size on each axis, so that tiles do not depend on where a drive
// begins and subtraction is exact. Axes are parallel to the world's, z up, metres.
struct MapFrame {
  Eigen::Vector3d origin_world_m = Eigen::Vector3d::Zero();

  // World coordinates of a point in the map frame: what users see of it everywhere but in dumps.
  [[nodiscard]] Eigen::Vector3d world_m(const Eigen::Vector3d& p_map_m) const {
    return p_map_m + origin_world_m;
  }
  friend bool operator==(const MapFrame&, const MapFrame&) = default;
};
SIGHTLINE_FIELDS(MapFrame, origin_world_m)

// The multiple of tile_m at or below `near_world_m` on each axis.
MapFrame frame_near(const Eigen::Vector3d& near_world_m, double tile_m);

// T_to_x from T_from_x: the same pose in another map frame of the same world.
Pose rebase(const Pose& T_from_x, const MapFrame& from, const MapFrame& to);

// True when the upper left 3x3 is a rotation to 1e-6 and every number is finite.
bool is_rigid(const Pose& pose);

// Linear in position, slerp in rotation; fraction in [0, 1].
Pose interpolate(const Pose& a, const Pose& b, double fraction);

// How dumps print them: a frame as facts origin_world_{x,y,z}_m, a pose as the columns
// x_m, y_m, z_m, qx, qy, qz, qw (unit quaternion, qw >= 0).
void append_facts(const MapFrame& frame, Table& table);
void append_pose_columns(std::vector<std::string>& columns);
void append_cells(const Pose& pose, std::vector<Cell>& row);

void encode(const Pose& pose, ByteWriter& writer);  // 3 + 9 doubles, exact
void decode(ByteReader& reader, Pose& pose);

// What Eigen's AngleAxis does, with the same bits on every machine: its sines and arc tangents are
// the C library's (formats/base/portable_math.h).
struct AxisAngle {
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  // unit length
  double angle_rad = 0.0;
};
AxisAngle axis_angle(const Eigen::Matrix3d& rotation);  // angle in [0, pi]
Eigen::Matrix3d rotation_matrix(const AxisAngle& turn);
double rotation_angle_rad(const Eigen::Matrix3d& rotation);        // in [0, pi]
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& rotation);  // axis times angle, rad

// The rotation nearest to a matrix that is one but for rounding: U V^T of its singular value
// decomposition (Kabsch 1976).
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& matrix);

// Of unit length: azimuth from +x to +y, elevation from the plane to +z.
Eigen::Vector3d direction_of(double azimuth_rad, double elevation_rad);

}  // namespace sightline
