#include <algorithm>
#include <cmath>
#include <limits>

#include "examples/town/world/furniture.h"

namespace sightline::town {
namespace {

constexpr double kReachM = 130.0;     // of the ground, from the driven line
constexpr double kFineReachM = 40.0;  // where it is laid in cells of 1 m
constexpr double kFineM = 1.0;
constexpr double kCoarseM = 4.0;
constexpr double kPavementM = 0.12;     // a kerb's height
constexpr double kUnderFacadesM = 2.0;  // pavements go on to where fronts stand back

double distance_to_line_m(const DrivenLine& line, const Eigen::Vector2d& point_m) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < line.points.size(); i += 16) {
    nearest = std::min(nearest, (line.points[i].position_m - point_m).norm());
  }
  return nearest;
}

Eigen::Vector3d on_ground(std::uint64_t seed, const Eigen::Vector2d& p, double above_m) {
  return Eigen::Vector3d(p.x(), p.y(), ground_height_m(seed, p) + above_m);
}

void add_ground_cell(TownMesh& mesh, std::uint64_t seed, const Eigen::Vector2d& low_m,
                     double size_m) {
  const Eigen::Vector2d u(size_m, 0.0);
  const Eigen::Vector2d v(0.0, size_m);
  add_quad(mesh,
           {on_ground(seed, low_m, 0.0), on_ground(seed, low_m + u, 0.0),
            on_ground(seed, low_m + u + v, 0.0), on_ground(seed, low_m + v, 0.0)},
           Label::kGround);
}

bool is_crossed(const TownPlan& plan, const Street& street, const Eigen::Vector2d& point_m) {
  return std::any_of(plan.streets.begin(), plan.streets.end(), [&](const Street& other) {
    return &other != &street && contains(roadway(other), point_m);
  });
}

// One metre of pavement between two laterals, with its kerb.
void add_pavement_cell(TownMesh& mesh, std::uint64_t seed, const Street& street, double along_m,
                       const std::array<double, 2>& laterals_m) {
  const Eigen::Vector2d a = street.at(along_m, laterals_m[0]);
  const Eigen::Vector2d b = street.at(along_m + kFineM, laterals_m[0]);
  const Eigen::Vector2d c = street.at(along_m + kFineM, laterals_m[1]);
  const Eigen::Vector2d d = street.at(along_m, laterals_m[1]);
  const Eigen::Vector3d high_a = on_ground(seed, a, kPavementM);
  const Eigen::Vector3d high_b = on_ground(seed, b, kPavementM);
  add_quad(mesh, {high_a, high_b, on_ground(seed, c, kPavementM), on_ground(seed, d, kPavementM)},
           Label::kKerb);
  add_quad(mesh, {on_ground(seed, a, -0.1), on_ground(seed, b, -0.1), high_b, high_a},
           Label::kKerb);
}

void add_pavement(TownMesh& mesh, std::uint64_t seed, const TownPlan& plan, const Street& street,
                  const std::array<double, 2>& laterals_m) {
  const double end_m = street.length_m + street.after_m;
  for (double along_m = -street.before_m; along_m < end_m - kFineM; along_m += kFineM) {
    const double middle_m = along_m + 0.5 * kFineM;
    if (is_crossed(plan, street, street.at(middle_m, laterals_m[0])) ||
        is_crossed(plan, street, street.at(middle_m, laterals_m[1]))) {
      continue;
    }
    add_pavement_cell(mesh, seed, street, along_m, laterals_m);
  }
}

}  // namespace

void add_ground(TownMesh& mesh, std::uint64_t seed, const TownPlan& plan) {
  Eigen::Array2d low = Eigen::Array2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Array2d high = -low;
  for (const LinePoint& point : plan.line.points) {
    low = low.min(point.position_m.array());
    high = high.max(point.position_m.array());
  }
  // On multiples of the coarse cell, so that the mesh does not depend on where the line ends.
  const Eigen::Array2d first = ((low - kReachM) / kCoarseM).floor() * kCoarseM;
  for (double x = first.x(); x < high.x() + kReachM; x += kCoarseM) {
    for (double y = first.y(); y < high.y() + kReachM; y += kCoarseM) {
      const Eigen::Vector2d corner(x, y);
      const double middle = 0.5 * kCoarseM;
      const double away_m = distance_to_line_m(plan.line, corner + Eigen::Vector2d(middle, middle));
      if (away_m > kReachM) continue;
      const double size_m = away_m < kFineReachM ? kFineM : kCoarseM;
      for (double dx = 0.0; dx < kCoarseM; dx += size_m) {
        for (double dy = 0.0; dy < kCoarseM; dy += size_m) {
          add_ground_cell(mesh, seed, corner + Eigen::Vector2d(dx, dy), size_m);
        }
      }
    }
  }
}

void add_pavements(TownMesh& mesh, std::uint64_t seed, const TownPlan& plan) {
  for (const Street& street : plan.streets) {
    if (street.has_pavement_left()) {
      add_pavement(mesh, seed, plan, street, {street.kerb_left_m, street.left_m + kUnderFacadesM});
    }
    if (street.has_pavement_right()) {
      add_pavement(mesh, seed, plan, street,
                   {-street.kerb_right_m, -street.right_m - kUnderFacadesM});
    }
  }
}

}  // namespace sightline::town
