#include "passes/trajectory/following/scan_runs.h"

#include <algorithm>
#include <cmath>

#include "passes/trajectory/local/local_match.h"

namespace sightline {
namespace {

constexpr double kLocalMapsOfTwoRuns = 10.0;
// A run begins with a local map of so many scans, even if a given pose jumps.
constexpr double kLeastScansOfLocalMap = 10.0;

// Scans of one part from `begin` on, with given steps between them, and the way up to each.
struct GivenWay {
  std::size_t begin = 0;
  std::vector<double> way_m = {0.0};
};

// Adds the runs that begin within such a way.
void add_runs_within(const GivenWay& given, double local_map_m, std::vector<ScanRun>& runs) {
  const std::vector<double>& way_m = given.way_m;
  const double pairs = way_m.back() / (kLocalMapsOfTwoRuns * local_map_m);
  // Even: with three runs and two threads, one thread would be idle during the last.
  const double count = pairs < 1.0 ? 1.0 : 2.0 * std::round(pairs);
  for (double i = 1.0; i < count; i += 1.0) {
    const auto begin = std::ranges::lower_bound(way_m, way_m.back() * i / count);
    const auto first = std::ranges::lower_bound(way_m.begin(), begin, *begin - local_map_m);
    runs.push_back({given.begin + static_cast<std::size_t>(first - way_m.begin()),
                    given.begin + static_cast<std::size_t>(begin - way_m.begin())});
  }
}

// Appends a scan of a run.
void append_scan(const Odometry& from, std::size_t k, const Pose& T_joined_found, Odometry& to) {
  const Pose T_map_lidar = tidied(T_joined_found * from.T_map_lidar[k]);
  const double step_m =
      k == 0 ? 0.0
             : (from.T_map_lidar[k].translation() - from.T_map_lidar[k - 1].translation()).norm();
  to.append(T_map_lidar, step_m, from.is_matched[k], from.overlap[k]);
  to.is_far.back() = from.is_far[k];
}

// Appends a run.
void append_run(const ScanRun& run, const Odometry& found, Odometry& joined) {
  const bool begins_piece = run.first == run.begin;
  const std::size_t before = begins_piece ? 0 : run.begin - run.first - 1;  // in both
  const Pose T_joined_found = joined.T_map_lidar.back() * found.T_map_lidar[before].inverse();
  const std::uint32_t first_piece = joined.piece.back() + (begins_piece ? 1 : 0);
  if (begins_piece) {
    joined.piece_starts.push_back({static_cast<std::uint32_t>(run.begin), true, 0.0, 0.0});
  }
  joined.piece_starts.insert(joined.piece_starts.end(), found.piece_starts.begin(),
                             found.piece_starts.end());
  for (std::size_t k = run.begin - run.first; k < found.T_map_lidar.size(); ++k) {
    append_scan(found, k, T_joined_found, joined);
    joined.piece.back() = first_piece + found.piece[k];
  }
  if (begins_piece) joined.is_matched[run.begin] = false;
}

}  // namespace

std::vector<ScanRun> scan_runs(const Drive& drive, const GivenPoses& given, double local_map_m) {
  const double longest_step_m = local_map_m / kLeastScansOfLocalMap;
  std::vector<ScanRun> runs = {{}};
  GivenWay way;
  for (std::size_t k = 1; k < drive.scans.size(); ++k) {
    const bool begins_part = drive.scans[k].part != drive.scans[k - 1].part;
    if (!begins_part && given[k - 1] && given[k]) {
      const Eigen::Vector3d step_m = given[k]->translation() - given[k - 1]->translation();
      way.way_m.push_back(way.way_m.back() + std::min(step_m.norm(), longest_step_m));
      continue;
    }
    add_runs_within(way, local_map_m, runs);
    way = {.begin = k};
    if (begins_part) runs.push_back({k, k});
  }
  add_runs_within(way, local_map_m, runs);
  for (std::size_t i = 1; i < runs.size(); ++i) runs[i - 1].end = runs[i].begin;
  runs.back().end = drive.scans.size();
  return runs;
}

Odometry joined_runs(std::span<const ScanRun> runs, const std::vector<Odometry>& followed) {
  Odometry joined = followed.front();
  for (std::size_t i = 1; i < runs.size(); ++i) append_run(runs[i], followed[i], joined);
  return joined;
}

}  // namespace sightline
