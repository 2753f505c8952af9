#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "formats/geometry.h"
#include "formats/surroundings/ndt_map.h"
#include "passes/matching/grid/match_grid.h"
#include "passes/matching/localizer.h"

// Factors from a virtual scan (schemas/definitions.md): its information about the pose of the
// sensor, bounds that follow from it, and the scan localized.

namespace sightline {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

// What the samples within one range add up to. Motion is x -> x + t + w cross (x - p), map axes,
// rows and columns in the order t_x, t_y, t_z, w_x, w_y, w_z.
struct ScanInformation {
  Matrix6d pose = Matrix6d::Zero();  // sum of J^T Sigma^-1 J, without prior
  // Sum of n n^T over 2D NDs, horizontal part.
  Eigen::Matrix2d planar_normals = Eigen::Matrix2d::Zero();
  std::size_t point_count = 0;      // samples, in valid NDs or not
  std::size_t unmatched_count = 0;  // of them, in no valid ND
};

// Adds J^T A J of one sample r from p, with J = [I, -[r]x] and A the inverse covariance of its ND.
void add_sample(const Eigen::Vector3d& r_m, const Eigen::Matrix3d& information_per_m2,
                Matrix6d& pose);

// One for each range, nearer samples first. `points_m` are relative to p_map_m; `grid` was made
// from `map`.
std::vector<ScanInformation> scan_information(const Eigen::Vector3d& p_map_m,
                                              std::span<const Eigen::Vector3d> points_m,
                                              const NdtMap& map, const MatchGrid& grid,
                                              const std::vector<double>& ranges_m);

// The Cramer-Rao bound of the samples with the prior of schemas/definitions.md (10 m, 10 degrees).
// It takes samples as independent: it ranks places and is no accuracy.
struct Crlb {
  double max_m = 0.0;        // along the weakest horizontal direction
  double min_m = 0.0;        // along the strongest
  double heading_deg = 0.0;  // of the weakest, counter-clockwise from map +x, in [0, 180)
  double yaw_rad = 0.0;
};
Crlb crlb(const Matrix6d& information);

// Along a horizontal line of this heading, degrees from map +x, m: between min_m and max_m.
double std_along_m(const Crlb& bound, double heading_deg);

// Smallest eigenvalue of the summed horizontal part of n n^T: near 0 where some horizontal
// direction is constrained by nothing (schemas/definitions.md, `hz_lmin`). Never below 0.
double hz_lmin(const Eigen::Matrix2d& planar_normals);

// Where and how a virtual scan is localized.
struct VirtualPlace {
  Eigen::Vector3d p_map_m;
  Eigen::Matrix3d R_map_vehicle;              // starts are laid out along the vehicle
  std::span<const Eigen::Vector3d> points_m;  // within the range, from p, map axes
  double loose_heading_deg = 0.0;             // crlb_heading
};

struct VirtualMatch {
  // Mean distance from p over the starts of "Measured error", which see four views, a quarter of
  // the azimuths hidden in each.
  double error_m = 0.0;
  // The best score 0.5 to 2.5 m off along the loose direction, over that at p, of points that lead.
  double rival_score = 1.0;
};
// As a vehicle localizes its own scan. Shows other optima, which bounds around the right pose miss.
VirtualMatch virtual_match(const Localizer& localizer, const VirtualPlace& place);

}  // namespace sightline
