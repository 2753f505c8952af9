// Follows a pose file through a compiled map and prints at each pose how far to look, the cheapest
// look there, and what a vehicle does that tracks, as this one does from its third pose on:
//
//   vehicle_reader MAP POSES [LIMIT_M [LOCALIZER]]
//
// POSES is a TUM file: lines "time x y z qx qy qz qw" in the world the map was made in, the
// sensor's own poses; '#' begins a comment. LIMIT_M is the accuracy that is needed, 0.10 m unless
// given. LOCALIZER is what the vehicle localizes with, the compiler's own unless given: a map knows
// probabilities for the localizer whose errors were measured and for no other. It links nothing but
// the reader.

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

#include "formats/reader/reader.h"

namespace {

using sightline::LookAnswer;
using sightline::LookPlanAnswer;
using sightline::MapReader;
using sightline::RangeAnswer;
using sightline::Result;

std::string flag_names(std::uint32_t flags) {
  std::string names;
  const auto add = [&](std::uint32_t flag, const char* name) {
    if ((flags & flag) != 0) names += names.empty() ? name : std::string("+") + name;
  };
  add(sightline::kAnswerUnmet, "unmet");
  add(sightline::kAnswerExtrapolated, "extrapolated");
  add(sightline::kAnswerFar, "far");
  add(sightline::kAnswerTighterLimit, "tighter-limit");
  add(sightline::kAnswerStatic, "static");
  add(sightline::kAnswerUnknownLocalizer, "unknown-localizer");
  add(sightline::kAnswerNotVisible, "not-visible");
  add(sightline::kAnswerSimulated, "simulated");
  return names.empty() ? "-" : names;
}

// A map that expects to be wrong here is not followed blindly: who asks looks again, closer and
// from his own forecast, or goes by other sensors.
bool is_trusted(const LookAnswer& look) {
  constexpr double kLeastProbability = 0.5;
  const bool is_known = (look.flags & sightline::kAnswerUnknownLocalizer) == 0;
  return is_known && look.probability >= kLeastProbability &&
         (look.flags & sightline::kAnswerUnmet) == 0;
}

// False where the line cannot be read, which is reported.
bool print_line(const MapReader& map, const std::string& line, double limit_m, bool is_tracking) {
  std::istringstream fields(line);
  std::string time;
  std::array<double, 3> p_m{};
  if (!(fields >> time >> p_m[0] >> p_m[1] >> p_m[2])) {
    std::fprintf(stderr, "not a pose: %s\n", line.c_str());
    return false;
  }
  const Result<RangeAnswer> answer = map.observation_range(p_m, limit_m);
  const Result<LookAnswer> look = map.look(p_m, limit_m);
  const Result<LookPlanAnswer> plan = map.look_plan(p_m, limit_m, is_tracking);
  if (!answer || !look || !plan) {
    const sightline::Error& error = !answer ? answer.error() : !look ? look.error() : plan.error();
    std::fprintf(stderr, "%s\n", to_string(error).c_str());
    return false;
  }
  std::printf("%s %.3f %.3f %.3f %g %.4f %s %.3f %u %u %.4f %s %u %u\n", time.c_str(), p_m[0],
              p_m[1], p_m[2], answer->range_m, answer->probability,
              flag_names(answer->flags).c_str(), answer->distance_m, look->look.return_count,
              look->look.point_count, look->probability, is_trusted(*look) ? "-" : "careful",
              plan->first.look.point_count, plan->second.point_count);
  return true;
}

// What the limits of the map are worth on this drive.
void print_promises(const MapReader& map) {
  for (const sightline::MapPromise& promise : map.info().promises) {
    std::printf("# within %g m: %s\n", promise.limit_m, std::string(promise.statement).c_str());
  }
}

int follow(const MapReader& map, std::istream& poses, double limit_m) {
  std::printf("# map %s, version %s, release %llu; limit %g m\n",
              std::string(map.info().map_id).c_str(), std::string(map.info().version).c_str(),
              static_cast<unsigned long long>(map.info().release), limit_m);
  print_promises(map);
  std::printf(
      "# time x_m y_m z_m range_m probability flags distance_to_site_m "
      "look_returns look_points look_probability careful first_points second_points\n");
  std::string line;
  int pose_count = 0;
  while (std::getline(poses, line)) {
    if (line.empty() || line[0] == '#') continue;
    if (!print_line(map, line, limit_m, pose_count++ >= 2)) return 65;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3 || argc > 5) {
    std::fprintf(stderr, "usage: %s MAP POSES [LIMIT_M [LOCALIZER]]\n", argv[0]);
    return 64;
  }
  const double limit_m = argc >= 4 ? std::atof(argv[3]) : 0.10;
  const Result<MapReader> map = MapReader::open(argv[1], argc == 5 ? argv[4] : "searching");
  if (!map) {
    std::fprintf(stderr, "%s\n", to_string(map.error()).c_str());
    return sightline::exit_status(map.error().code);
  }
  std::ifstream poses(argv[2]);
  if (!poses) {
    std::fprintf(stderr, "cannot read %s\n", argv[2]);
    return 65;
  }
  return follow(*map, poses, limit_m);
}
