// sightline_town: makes recordings of a generated town.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "examples/town/write_town.h"

namespace {

struct ChangeFlags {
  std::vector<double> stretch_m = {0.0, 0.0};
  std::vector<std::string> kinds = {"buildings", "wall", "cars", "noise"};
  double noise_factor = sightline::town::TownChange{}.noise_factor;
};

sightline::town::TownChange change_of(const ChangeFlags& flags) {
  const auto has = [&](const char* kind) {
    return std::find(flags.kinds.begin(), flags.kinds.end(), kind) != flags.kinds.end();
  };
  sightline::town::TownChange change;
  change.from_m = flags.stretch_m[0];
  change.to_m = flags.stretch_m[1];
  change.rebuilds = has("buildings");
  change.removes_wall = has("wall");
  if (!has("cars")) change.added_cars = 0;
  change.noise_factor = has("noise") ? flags.noise_factor : 1.0;
  return change;
}

// Numbers in threes, x and y of the world and degrees from +x; and the size of them all.
struct BoardFlags {
  std::vector<double> places;
  std::vector<double> size_m = {1.0, 2.0};
};

std::vector<sightline::town::Board> boards_of(const BoardFlags& flags,
                                              const Eigen::Vector2d& origin_world_m) {
  std::vector<sightline::town::Board> boards;
  for (std::size_t i = 0; i + 2 < flags.places.size(); i += 3) {
    sightline::town::Board board;
    board.pose.position_m = Eigen::Vector2d(flags.places[i], flags.places[i + 1]) - origin_world_m;
    board.pose.yaw_rad = sightline::town::to_radians(flags.places[i + 2]);
    board.width_m = flags.size_m[0];
    board.height_m = flags.size_m[1];
    boards.push_back(board);
  }
  return boards;
}

struct WorldFlags {
  std::string world = "town";
  bool is_bare = false;
};

void add_world_options(CLI::App& app, WorldFlags& flags,
                       sightline::town::WriteTownOptions& options) {
  std::vector<std::string> names;
  for (const std::string_view name : sightline::town::world_kind_names()) {
    names.emplace_back(name);
  }
  app.add_option("--world", flags.world,
                 "town: a town of streets; or a world of places that are hard to map, 300 m long; "
                 "mixed: all of them in random order, 120 m each. These begin and end with 40 m "
                 "of town, and roads of even seeds have no details")
      ->capture_default_str()
      ->check(CLI::IsMember(names));
  app.add_flag("--bare", flags.is_bare, "a hard world without the town at both ends");
  app.add_flag("--fog", options.has_fog,
               "patches of fog within 12 m, which travel with the sensor");
  app.add_option("--covered", options.covered_deg,
                 "angle of the view, around straight behind, that is hidden, degrees")
      ->check(CLI::Range(0.0, 359.0));
  app.add_option("--constraints", options.constraints_m,
                 "m between scans of a hard world for which constraints.csv, in each drive's "
                 "folder, lists which directions a scan constrains in truth")
      ->check(CLI::Range(0.5, 1000.0));
}

}  // namespace

int main(int argc, char** argv) {
  using namespace sightline;
  town::WriteTownOptions options;
  std::vector<double> origin_m = {0.0, 0.0};
  ChangeFlags change;
  std::vector<double> part_numbers;
  BoardFlags boards;
  WorldFlags world;
  CLI::App app("Makes a town from a seed, drives through it, and writes what a LiDAR records.");
  app.add_option("--seed", options.town.seed, "makes the town")->capture_default_str();
  const CLI::Option* length =
      app.add_option("--length-m", options.town.length_m, "length of the route, m")
          ->capture_default_str();
  add_world_options(app, world, options);
  app.add_flag("--round", options.town.is_round, "the route is a closed loop round a block");
  app.add_option("-o,--output", options.out, "folder to write")->required();
  app.add_option("--drives", options.drives, "localization drives beside the mapping drive")
      ->capture_default_str();
  app.add_option("--beams", options.beams, "16, 32, 64 or 128")->capture_default_str();
  app.add_option("--sensor", options.sensor,
                 "instead of --beams: a sensor profile (livox-avia), or a file with its beams");
  app.add_option("--spacing-m", options.spacing_m, "route between two scans, m")
      ->capture_default_str();
  app.add_flag("--by-hand", options.is_by_hand,
               "as who walks with a sensor in the hand: two scans a second, 0.7 m apart, and "
               "turns of 60 degrees between two");
  app.add_flag("--swept", options.is_swept,
               "each drive is a bag (drive.mcap) of a sensor that turns while its driver steers to "
               "and fro: points with times, odometry and an inertial unit");
  app.add_option("--traffic", options.traffic,
                 "times the usual number of cars and people, 0.1 to 10")
      ->capture_default_str();
  app.add_option("--missing", options.missing_share,
                 "share of returns that fail to come, by chance alone")
      ->capture_default_str();
  app.add_option("--part", part_numbers,
                 "DRIVE,FROM,TO: that drive (0: mapping) covers only this stretch of the route, m; "
                 "may be given for each drive")
      ->delimiter(',')
      ->expected(3)
      ->take_all();
  app.add_option("--next-lane", options.in_next_lane,
                 "drives that keep to the oncoming lane, where a street has one")
      ->delimiter(',');
  app.add_option("--back", options.back, "drives from the end of the route to its beginning")
      ->delimiter(',');
  app.add_option("--origin-m", origin_m, "world coordinates x,y of the route's start, m")
      ->delimiter(',')
      ->expected(2);
  app.add_option(
         "--change", change.stretch_m,
         "a stretch FROM,TO of the route, m, where the same town looks different: what a map "
         "of the town without this option no longer shows")
      ->delimiter(',')
      ->expected(2);
  app.add_option("--change-only", change.kinds,
                 "of these alone instead of all: buildings (other fronts and heights), wall (the "
                 "longest house is gone), cars (ten more are parked), noise (of ranges)")
      ->delimiter(',')
      ->check(CLI::IsMember({"buildings", "wall", "cars", "noise"}));
  app.add_option("--change-noise", change.noise_factor, "how many times as much noise that is")
      ->capture_default_str()
      ->check(CLI::Range(1.0, 100.0));
  app.add_option("--board", boards.places,
                 "a flat board on a pole at world coordinates X,Y that faces DEGREES from +x; may "
                 "be given several times")
      ->type_name("X,Y,DEGREES")
      ->delimiter(',');
  app.add_option("--board-size", boards.size_m, "width and height of each, m")
      ->delimiter(',')
      ->expected(2)
      ->capture_default_str();
  app.add_flag("--force", options.replaces, "replace an earlier town");
  app.add_option("--threads", options.threads, "0: all there are")->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int status = app.exit(error);
    return status == 0 ? 0 : exit_status(ErrorCode::kBadArgument);
  }
  if (boards.places.size() % 3 != 0) {
    std::fprintf(stderr, "--board: found %zu numbers, expected three for each board\n",
                 boards.places.size());
    return exit_status(ErrorCode::kBadArgument);
  }
  options.town.world = *town::world_kind(world.world);
  options.town.is_bare = world.is_bare;
  if (length->count() == 0) options.town.length_m = town::usual_length_m(options.town.world);
  options.town.change = change_of(change);
  for (std::size_t i = 0; i + 2 < part_numbers.size(); i += 3) {
    options.parts.push_back(
        {static_cast<int>(part_numbers[i]), part_numbers[i + 1], part_numbers[i + 2]});
  }
  options.origin_world_m = Eigen::Vector2d(origin_m[0], origin_m[1]);
  options.town.boards = boards_of(boards, options.origin_world_m);
  const Result<void> written = town::write_town(options);
  if (!written) {
    std::fprintf(stderr, "%s\n", to_string(written.error()).c_str());
    return exit_status(written.error().code);
  }
  return 0;
}
