#include "examples/town/whole/town.h"

#include <cmath>
#include <set>
#include <string>

#include "examples/town/world/hard/hard_world.h"
#include "examples/town/world/make_plan.h"
#include "formats/base/random.h"

namespace sightline::town {
namespace {

constexpr double kShortestM = 20.0;
constexpr double kShortestRoundM = 200.0;  // houses and two streets must fit inside
constexpr double kLongestM = 20000.0;      // float coordinates keep 2 mm there

constexpr std::uint64_t kClutterKey = 0x636c7574ULL;
constexpr std::uint64_t kFrontKey = 0x66726f6eULL;
constexpr std::uint64_t kParkedKey = 0x70636172ULL;
constexpr std::uint64_t kChangeKey = 0x63686e67ULL;

void add_clutter(TownMesh& mesh, const Town& town, std::uint64_t drive) {
  constexpr double kGone = 0.1;
  constexpr double kNew = 0.1;
  const std::uint64_t seed = mix(town.options.seed, kClutterKey);
  for (std::size_t b = 0; b < town.buildings.size(); ++b) {
    if (town.buildings[b].is_gone) continue;
    const std::vector<Box> items = draw_clutter(town.buildings[b], mix(seed, b));
    Random random(mix(mix(seed, drive), b));
    for (const Box& item : items) {
      const bool is_gone = random.uniform() < kGone;
      const bool is_joined = random.uniform() < kNew;
      const std::uint64_t new_seed = random.next();
      if (drive == 0 || !is_gone) add_box(mesh, item, Label::kClutter);
      if (drive != 0 && is_joined) {
        add_box(mesh, draw_clutter_item(town.buildings[b], new_seed), Label::kClutter);
      }
    }
  }
}

void add_parked_cars(TownMesh& mesh, const Town& town, std::uint64_t drive) {
  const std::uint64_t seed = mix(mix(town.options.seed, kParkedKey), drive);
  std::vector<Pose2d> cars = parked_cars(seed, town.plan);
  for (const Pose2d& car : added_cars(town.options.change, mix(seed, kChangeKey), town.plan)) {
    cars.push_back(car);
  }
  for (std::size_t i = 0; i < cars.size(); ++i) {
    const double ground_m = ground_height_m(town.options.seed, cars[i].position_m);
    add_vehicle(mesh, cars[i], ground_m, mix(seed, i), Label::kParkedCar);
  }
}

Result<void> check_boards(const std::vector<Board>& boards) {
  constexpr double kLargestM = 20.0;
  for (const Board& board : boards) {
    const bool is_placed = board.pose.position_m.cwiseAbs().maxCoeff() <= kLongestM &&
                           std::isfinite(board.pose.yaw_rad);
    const auto has_size = [&](double size_m) { return size_m > 0.0 && size_m <= kLargestM; };
    if (is_placed && has_size(board.width_m) && has_size(board.height_m)) continue;
    return Error{ErrorCode::kBadArgument,
                 "a board of " + std::to_string(board.width_m) + " x " +
                     std::to_string(board.height_m) +
                     " m; expected up to 20 x 20 m, within 20000 m of the start",
                 {},
                 {}};
  }
  return {};
}

Result<Town> make_hard_town(const TownOptions& options) {
  const double shortest_m = options.is_bare ? kShortestBare_m : kShortestHard_m;
  if (!(options.length_m >= shortest_m && options.length_m <= kLongestM)) {
    return Error{ErrorCode::kBadArgument,
                 "a world of kind " + std::string(world_kind_name(options.world)) +
                     " has a length of " + std::to_string(shortest_m) + " to 20000 m; found " +
                     std::to_string(options.length_m) + " m",
                 {},
                 {}};
  }
  if (options.is_round || options.change.is_any() || !options.boards.empty()) {
    return Error{ErrorCode::kBadArgument,
                 "a round route, a changed stretch and boards are possible in a town only",
                 {},
                 {}};
  }
  Town town;
  town.options = options;
  town.places = order_places(options.seed, {options.world, options.is_bare, options.length_m});
  town.plan.line = make_road_line(options.seed, town.places);
  town.permanent = hard_mesh(town.road());
  return town;
}

Result<Town> make_street_town(const TownOptions& options) {
  const double shortest_m = options.is_round ? kShortestRoundM : kShortestM;
  if (!(options.length_m >= shortest_m && options.length_m <= kLongestM)) {
    return Error{ErrorCode::kBadArgument,
                 "a town of length " + std::to_string(options.length_m) + " m; expected " +
                     std::to_string(shortest_m) + " to 20000 m",
                 {},
                 {}};
  }
  const TownChange& change = options.change;
  if (change.is_any() && !(change.from_m >= 0.0 && change.to_m <= options.length_m)) {
    return Error{ErrorCode::kBadArgument,
                 "a change from " + std::to_string(change.from_m) + " to " +
                     std::to_string(change.to_m) + " m; the route has " +
                     std::to_string(options.length_m) + " m",
                 {},
                 {}};
  }
  SIGHTLINE_TRY(check_boards(options.boards));
  Town town;
  town.options = options;
  const std::uint64_t seed = options.seed;
  town.plan = options.is_round ? make_round_plan(seed, options.length_m)
                               : make_plan(seed, options.length_m);
  town.buildings = place_buildings(seed, town.plan);
  const std::set<std::size_t> rebuilt =
      change_buildings(options.change, mix(seed, kChangeKey), town.plan, town.buildings);
  add_ground(town.permanent, seed, town.plan);
  add_pavements(town.permanent, seed, town.plan);
  for (std::size_t b = 0; b < town.buildings.size(); ++b) {
    if (town.buildings[b].is_gone) continue;
    const std::uint64_t front = mix(mix(seed, kFrontKey), b);
    add_building(town.permanent, town.buildings[b],
                 rebuilt.contains(b) ? mix(front, kChangeKey) : front);
  }
  add_furniture(town.permanent, seed, town.plan);
  for (const Board& board : options.boards) {
    add_board(town.permanent, board, ground_height_m(seed, board.pose.position_m));
  }
  return town;
}

}  // namespace

TownMesh standing_mesh(const Town& town, std::uint64_t drive) {
  TownMesh mesh = town.permanent;
  if (town.is_hard()) {
    add_hard_cars(mesh, town.road(), drive);
    return mesh;
  }
  add_clutter(mesh, town, drive);
  add_parked_cars(mesh, town, drive);
  return mesh;
}

Result<Town> make_town(const TownOptions& options) {
  return options.world.is_hard ? make_hard_town(options) : make_street_town(options);
}

}  // namespace sightline::town
