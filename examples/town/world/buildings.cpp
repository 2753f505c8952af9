#include "examples/town/world/buildings.h"

#include <algorithm>
#include <cmath>

#include "formats/base/random.h"

namespace sightline::town {
namespace {

constexpr double kFoundationM = -0.4;  // walls begin below the uneven ground
constexpr double kFloorHeightM = 3.2;

// A front as seen from the street: u to the right along it, z up, depth into the house.
struct Front {
  const Building& building;

  [[nodiscard]] double width_m() const { return 2.0 * building.footprint.half_length_m; }
  [[nodiscard]] Eigen::Vector3d at(double u_m, double z_m, double depth_m) const {
    const Footprint& f = building.footprint;
    const Eigen::Vector2d along = direction(f.yaw_rad);
    const Eigen::Vector2d p =
        f.centre_m + (u_m - f.half_length_m) * along + (depth_m - f.half_width_m) * left_of(along);
    return Eigen::Vector3d(p.x(), p.y(), z_m);
  }
};

// An opening in a piece of wall from (u0, z0) to (u1, z1), `depth_m` deep; negative: it stands out.
struct Opening {
  double u0_m, u1_m, z0_m, z1_m;
  double depth_m;
  Label label;
};

void add_wall(TownMesh& mesh, const Front& front, const Opening& piece) {
  add_quad(mesh,
           {front.at(piece.u0_m, piece.z0_m, 0.0), front.at(piece.u1_m, piece.z0_m, 0.0),
            front.at(piece.u1_m, piece.z1_m, 0.0), front.at(piece.u0_m, piece.z1_m, 0.0)},
           Label::kFacade);
}

// The pane at its depth and the four reveals that join it to the wall.
void add_opening(TownMesh& mesh, const Front& front, const Opening& o) {
  const std::array<std::array<double, 2>, 4> corners = {
      {{o.u0_m, o.z0_m}, {o.u1_m, o.z0_m}, {o.u1_m, o.z1_m}, {o.u0_m, o.z1_m}}};
  std::array<Eigen::Vector3d, 4> pane;
  for (std::size_t i = 0; i < 4; ++i) pane[i] = front.at(corners[i][0], corners[i][1], o.depth_m);
  add_quad(mesh, pane, o.label);
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t j = (i + 1) % 4;
    add_quad(mesh,
             {front.at(corners[i][0], corners[i][1], 0.0),
              front.at(corners[j][0], corners[j][1], 0.0), pane[j], pane[i]},
             Label::kFacade);
  }
}

// One cell of a front: wall all around one opening.
void add_cell(TownMesh& mesh, const Front& front, const Opening& cell, const Opening& o) {
  add_wall(mesh, front, {cell.u0_m, o.u0_m, cell.z0_m, cell.z1_m, 0.0, Label::kFacade});
  add_wall(mesh, front, {o.u1_m, cell.u1_m, cell.z0_m, cell.z1_m, 0.0, Label::kFacade});
  add_wall(mesh, front, {o.u0_m, o.u1_m, cell.z0_m, o.z0_m, 0.0, Label::kFacade});
  add_wall(mesh, front, {o.u0_m, o.u1_m, o.z1_m, cell.z1_m, 0.0, Label::kFacade});
  add_opening(mesh, front, o);
}

// How the fronts of one house look.
struct FrontStyle {
  double pitch_m = 3.0;  // of the columns of windows
  double window_width_m = 1.2;
  double recess_m = 0.15;
  double door_share = 0.1;   // of the ground floor's cells: deep and down to the ground
  double blind_share = 0.0;  // of cells that are plain wall
  double ground_recess_m = 0.3;
  double jitter_m = 0.0;  // of openings along the front
};

FrontStyle front_style(StreetKind kind, Random& random) {
  FrontStyle style;
  style.pitch_m = random.uniform(2.4, 4.2);
  style.window_width_m = style.pitch_m * random.uniform(0.3, 0.55);
  style.recess_m = random.uniform(0.08, 0.25);
  style.door_share = random.uniform(0.08, 0.3);
  style.ground_recess_m = random.uniform(0.15, 0.5);
  style.jitter_m = 0.1 * style.pitch_m;
  style.blind_share = random.uniform(0.0, 0.4);
  if (kind == StreetKind::kLane) style.blind_share = random.uniform(0.35, 0.7);
  if (kind == StreetKind::kRepeating) {
    style = {3.0, 1.4, 0.3, 0.0, 0.0, 0.3, 0.0};
  }
  return style;
}

Opening draw_opening(const FrontStyle& style, const Opening& cell, Random& random) {
  const bool is_ground_floor = cell.z0_m < 0.0;
  const double middle_m = 0.5 * (cell.u0_m + cell.u1_m) + style.jitter_m * random.uniform(-1, 1);
  const double half_m = 0.5 * std::min(style.window_width_m, 0.7 * (cell.u1_m - cell.u0_m));
  Opening opening{middle_m - half_m, middle_m + half_m, cell.z1_m - 2.2,
                  cell.z1_m - 0.6,   style.recess_m,    Label::kWindow};
  if (is_ground_floor && random.uniform() < style.door_share) {
    opening.z0_m = 0.15;
    opening.depth_m = style.ground_recess_m;
    opening.label = Label::kFacade;
  }
  return opening;
}

void add_front(TownMesh& mesh, const Front& front, Random& random) {
  const FrontStyle style = front_style(front.building.kind, random);
  const int columns = std::max(1, static_cast<int>(front.width_m() / style.pitch_m));
  const int floors = std::max(1, static_cast<int>(front.building.height_m / kFloorHeightM));
  // Columns are an exact pitch apart; what is left of the front is plain wall at its far end.
  for (int floor = 0; floor < floors; ++floor) {
    const double z0_m = floor == 0 ? kFoundationM : kFloorHeightM * floor;
    const double z1_m = floor + 1 == floors ? front.building.height_m : kFloorHeightM * (floor + 1);
    for (int column = 0; column < columns; ++column) {
      const Opening cell{style.pitch_m * column, style.pitch_m * (column + 1), z0_m, z1_m, 0.0,
                         Label::kFacade};
      const Opening opening = draw_opening(style, cell, random);
      const bool is_blind = random.uniform() < style.blind_share;
      if (is_blind) {
        add_wall(mesh, front, cell);
      } else {
        add_cell(mesh, front, cell, opening);
      }
    }
    add_wall(mesh, front,
             {style.pitch_m * columns, front.width_m(), z0_m, z1_m, 0.0, Label::kFacade});
  }
}

// Sides, back and roof: plain.
void add_shell(TownMesh& mesh, const Building& building, bool with_front) {
  const Front front{building};
  const double depth_m = 2.0 * building.footprint.half_width_m;
  const std::array<std::array<double, 2>, 4> plan = {
      {{0.0, 0.0}, {front.width_m(), 0.0}, {front.width_m(), depth_m}, {0.0, depth_m}}};
  for (std::size_t i = with_front ? 0 : 1; i < 4; ++i) {
    const std::size_t j = (i + 1) % 4;
    add_quad(mesh,
             {front.at(plan[i][0], kFoundationM, plan[i][1]),
              front.at(plan[j][0], kFoundationM, plan[j][1]),
              front.at(plan[j][0], building.height_m, plan[j][1]),
              front.at(plan[i][0], building.height_m, plan[i][1])},
             Label::kFacade);
  }
  std::array<Eigen::Vector3d, 4> roof;
  for (std::size_t i = 0; i < 4; ++i) roof[i] = front.at(plan[i][0], building.height_m, plan[i][1]);
  add_quad(mesh, roof, Label::kFacade);
}

// Pieces of clutter for a metre of front.
double clutter_density(StreetKind kind) {
  switch (kind) {
    case StreetKind::kCanyon:
      return 0.22;
    case StreetKind::kLane:
      return 0.2;
    case StreetKind::kPlaza:
      return 0.15;
    case StreetKind::kSmooth:
      return 0.0;
    case StreetKind::kRepeating:
      return 0.02;
    case StreetKind::kAvenue:
      return 0.25;
    case StreetKind::kSide:
      break;
  }
  return 0.2;
}

// A box on a front: `standing_out_m` from the wall into the street.
Box box_on(const Front& front, double u_m, double length_m, double standing_out_m) {
  const Eigen::Vector3d centre = front.at(u_m, 0.0, -0.5 * standing_out_m);
  Box box;
  box.centre_m = centre.head<2>();
  box.yaw_rad = front.building.footprint.yaw_rad;
  box.length_m = length_m;
  box.width_m = standing_out_m;
  return box;
}

}  // namespace

void add_building(TownMesh& mesh, const Building& building, std::uint64_t seed) {
  const bool is_plain = building.is_background || building.kind == StreetKind::kSmooth;
  add_shell(mesh, building, is_plain);
  if (is_plain) return;
  Random random(seed);
  add_front(mesh, Front{building}, random);
}

Box draw_clutter_item(const Building& building, std::uint64_t seed) {
  Random random(seed);
  const Front front{building};
  const double u_m = random.uniform(0.8, std::max(0.9, front.width_m() - 0.8));
  const int floor = 1 + static_cast<int>(random.below(4));
  const double floor_m = std::min(kFloorHeightM * floor, building.height_m - 1.5);
  const bool is_narrow = building.kind == StreetKind::kLane;
  const auto box = [&](double length_m, double out_m, double bottom_m, double top_m) {
    Box item = box_on(front, std::min(u_m, front.width_m() - 0.5 * length_m), length_m,
                      is_narrow ? 0.5 * out_m : out_m);
    item.bottom_m = bottom_m;
    item.top_m = top_m;
    return item;
  };
  switch (random.below(6)) {
    case 0:
      return box(random.uniform(1.4, 3.0), random.uniform(0.6, 1.2), floor_m, floor_m + 1.0);
    case 1:
      return box(std::min(6.0, front.width_m()), 0.2, floor_m - 0.25, floor_m);
    case 2:
      return box(0.12, random.uniform(0.5, 0.9), 2.6, random.uniform(3.1, 4.2));
    case 3:
      return box(random.uniform(1.5, 3.0), random.uniform(0.7, 1.2), 2.6, 2.9);
    case 4:
      return box(0.12, 0.12, 0.0, building.height_m - 0.3);
    default:
      return box(random.uniform(0.6, 1.4), random.uniform(0.3, 0.5), 0.0, 0.8);
  }
}

std::vector<Box> draw_clutter(const Building& building, std::uint64_t seed) {
  std::vector<Box> items;
  if (building.is_background) return items;
  const double wanted = clutter_density(building.kind) * 2.0 * building.footprint.half_length_m;
  const auto count = static_cast<int>(wanted + Random(seed).uniform());
  for (int i = 0; i < count; ++i) {
    items.push_back(draw_clutter_item(building, mix(seed, static_cast<std::uint64_t>(i))));
  }
  return items;
}

}  // namespace sightline::town
