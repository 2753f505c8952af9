// Localizes one scan: where the vehicle is, from a first guess.
//
//   vehicle_localizer MAP SCAN X_M Y_M Z_M YAW_DEG [LIMIT_M]
//
// MAP is a compiled map (.slmap), which says how far to look for an accuracy of LIMIT_M (0.10 m
// unless given); or a point cloud (.pcd) or a folder of such clouds, in which 50 m far are looked.
// SCAN is a binary PCD of floats, x y z first, in the sensor's frame. The rest is a guess of the
// vehicle's pose in the map's world, level, good to about a metre and a few degrees.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "passes/vehicle/vehicle_localizer.h"

namespace {

using namespace sightline;

int refuse(const Error& error) {
  std::fprintf(stderr, "%s\n", to_string(error).c_str());
  return exit_status(error.code);
}

struct FloatCloud {
  std::vector<float> numbers;
  std::size_t numbers_a_point = 3;
};

// Nothing where it is no such file.
FloatCloud read_scan(const char* path) {
  std::ifstream file(path, std::ios::binary);
  FloatCloud cloud;
  std::size_t count = 0;
  std::string line, word;
  while (std::getline(file, line) && line != "DATA binary") {
    std::istringstream words(line);
    words >> word;
    if (word == "POINTS") words >> count;
    if (word != "FIELDS") continue;
    for (cloud.numbers_a_point = 0; words >> word;) ++cloud.numbers_a_point;
  }
  cloud.numbers.resize(file ? count * cloud.numbers_a_point : 0);
  file.read(reinterpret_cast<char*>(cloud.numbers.data()),
            static_cast<std::streamsize>(cloud.numbers.size() * sizeof(float)));
  if (!file) cloud.numbers.clear();
  return cloud;
}

void print(const MapLook& look, double probability, const sightline_match& match) {
  constexpr std::string_view kStops[] = {"converged", "iteration limit", "no points", "no overlap"};
  std::printf("range_m %g probability %.4f\n", look.range_m, probability);
  std::printf("stop %s\n", kStops[match.stop].data());
  const double* T = match.T_world_vehicle;
  std::printf("position_world_m %.17g %.17g %.17g\n", T[3], T[7], T[11]);
  std::printf("heading %.17g %.17g\n", T[0], T[4]);
  std::printf("score %.17g iterations %d points %u scored %u\n", match.score, match.iterations,
              match.point_count, match.scored_points);
  // Of a start of which nothing is known: a filter passes its own covariance.
  const double* c = match.covariance;
  std::printf("variance_m2 %.17g %.17g %.17g weak %u\n", c[0], c[7], c[14], match.weak);
}

int localize(const std::string& map_path, const sightline_points& scan,
             const std::array<double, 3>& guess_m, double yaw_rad, double limit_m) {
  const Result<VehicleLocalizer> localizer = VehicleLocalizer::open(map_path);
  if (!localizer) return refuse(localizer.error());
  LookAnswer look;
  look.look.range_m = 50.0;
  if (map_path.ends_with(".slmap")) {
    const Result<MapReader> map = MapReader::open(map_path, localizer->info().localizer);
    if (!map) return refuse(map.error());
    const Result<LookAnswer> answer = map->look(guess_m, limit_m);
    if (!answer) return refuse(answer.error());
    look = *answer;
  }
  const PoseRows T_world_guess =
      pose_rows(guess_m, {0.0, 0.0, std::sin(yaw_rad / 2.0), std::cos(yaw_rad / 2.0)});
  const Result<sightline_match> match = localizer->match(scan, T_world_guess, look.look);
  if (!match) return refuse(match.error());
  print(look.look, look.probability, *match);
  return match->stop == SIGHTLINE_NO_POINTS || match->stop == SIGHTLINE_NO_OVERLAP ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 7 || argc > 8) {
    std::fprintf(stderr, "usage: %s MAP SCAN X_M Y_M Z_M YAW_DEG [LIMIT_M]\n", argv[0]);
    return 64;
  }
  const FloatCloud cloud = read_scan(argv[2]);
  if (cloud.numbers.empty()) {
    std::fprintf(stderr, "%s is not a binary PCD of floats\n", argv[2]);
    return 65;
  }
  return localize(argv[1], points_of(std::span<const float>(cloud.numbers), cloud.numbers_a_point),
                  {std::atof(argv[3]), std::atof(argv[4]), std::atof(argv[5])},
                  std::atof(argv[6]) * std::numbers::pi / 180.0,
                  argc == 8 ? std::atof(argv[7]) : 0.10);
}
