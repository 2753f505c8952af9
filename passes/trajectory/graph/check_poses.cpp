#include "passes/trajectory/graph/check_poses.h"

#include <fmt/format.h>
#include <cmath>
#include <map>
#include <span>
#include <utility>

#include "formats/base/parallel.h"
#include "formats/base/portable_math.h"
#include "formats/base/statistics.h"
#include "formats/grid/point_grid.h"
#include "passes/pass/notices.h"
#include "passes/trajectory/local/local_match.h"
#include "passes/trajectory/local/parts_of_drive.h"
#include "passes/trajectory/pieces/seek_piece.h"

namespace sightline {
namespace {

constexpr std::size_t kWindow = 6;  // loops
constexpr std::size_t kLeastOff = 3;
constexpr double kMet_m = 0.25;

// A loop, its later scan first, and how far the trajectory is from it.
struct JudgedLoop {
  std::uint32_t later = 0;
  std::uint32_t earlier = 0;
  double off_m = 0.0;

  [[nodiscard]] bool is_off() const { return off_m > kMet_m; }
  auto operator<=>(const JudgedLoop&) const = default;
};

Contradiction contradiction_of(std::span<const JudgedLoop> loops) {
  const JudgedLoop& worst = *std::ranges::max_element(loops, {}, &JudgedLoop::off_m);
  return {loops.front().later,
          loops.back().later,
          static_cast<std::uint32_t>(loops.size()),
          static_cast<std::uint32_t>(std::ranges::count_if(loops, &JudgedLoop::is_off)),
          worst.earlier,
          worst.later,
          worst.off_m};
}

// Adds the contradictions by loops between two pieces, ascending.
void add_contradictions(std::span<const JudgedLoop> loops, std::vector<Contradiction>& found) {
  const std::size_t window = std::min(kWindow, loops.size());
  const std::size_t least = std::max(kLeastOff, (window + 1) / 2);
  std::size_t begin = 0;  // of the loops of windows that are off, one reaching into the next
  std::size_t end = 0;
  for (std::size_t first = 0; first + window <= loops.size(); ++first) {
    const auto off = std::ranges::count_if(loops.subspan(first, window), &JudgedLoop::is_off);
    if (static_cast<std::size_t>(off) < least) continue;
    if (first > end || end == 0) {
      if (end > 0) found.push_back(contradiction_of(loops.subspan(begin, end - begin)));
      begin = first;
    }
    end = first + window;
  }
  if (end > 0) found.push_back(contradiction_of(loops.subspan(begin, end - begin)));
}

constexpr double kMeetingStep_m = 2.0;  // of the later way
constexpr double kBeside_m = 8.0;
constexpr std::size_t kMostEarlier = 3;  // parts that a later one is compared with
constexpr std::size_t kMostScans = 4;    // of a pair

// A scan of a later part, and the nearest one of an earlier part.
struct Meeting {
  std::uint32_t later = 0;
  std::uint32_t earlier = 0;
};
// Of two parts.
struct MeetingsOfPair {
  std::uint32_t earlier = 0;
  std::uint32_t later = 0;
  std::vector<Meeting> meetings;
};

// The trajectory as an odometry whose pieces are runs of scans of one part and piece.
Odometry as_odometry(const Drive& drive, const Trajectory& trajectory) {
  Odometry odometry;
  const std::vector<Pose> T_map_lidar = sensor_poses(drive, trajectory);
  for (std::size_t i = 0; i < T_map_lidar.size(); ++i) {
    const bool begins = i > 0 && (drive.scans[i].part != drive.scans[i - 1].part ||
                                  trajectory.poses[i].piece != trajectory.poses[i - 1].piece);
    odometry.append_known(T_map_lidar[i], begins, trajectory.poses[i].overlap);
  }
  return odometry;
}

// The places of the scans of each part; those of other parts are not finite, and are not found.
std::vector<PointGrid> places_by_part(const Drive& drive, const Odometry& odometry) {
  std::vector<PointGrid> places;
  for (std::uint32_t part = 0; part <= drive.later_parts.size(); ++part) {
    std::vector<Eigen::Vector3d> places_m;
    for (std::size_t i = 0; i < drive.scans.size(); ++i) {
      places_m.push_back(drive.scans[i].part == part
                             ? Eigen::Vector3d(odometry.T_map_lidar[i].translation())
                             : Eigen::Vector3d::Constant(std::nan("")));
    }
    places.emplace_back(places_m);
  }
  return places;
}

// Each later part with the earlier ones that it meets most: the work does not grow with the square
// of the number of drives.
std::vector<MeetingsOfPair> pairs_that_meet(const Drive& drive, const Odometry& odometry,
                                            std::size_t from) {
  const std::vector<PointGrid> places = places_by_part(drive, odometry);
  std::vector<std::vector<MeetingsOfPair>> of_later(places.size());
  for (std::uint32_t later = 0; later < places.size(); ++later) {
    for (std::uint32_t earlier = 0; earlier < later; ++earlier) {
      of_later[later].push_back({earlier, later, {}});
    }
  }
  double next_m = 0.0;
  for (std::size_t i = from; i < drive.scans.size(); ++i) {
    if (odometry.driven_m[i] < next_m) continue;
    next_m = odometry.driven_m[i] + kMeetingStep_m;
    for (MeetingsOfPair& pair : of_later[drive.scans[i].part]) {
      const std::optional<NearPoint> nearest =
          places[pair.earlier].nearest_on_level(odometry.T_map_lidar[i].translation(), kBeside_m);
      if (!nearest) continue;
      pair.meetings.push_back(
          {static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(nearest->index)});
    }
  }
  std::vector<MeetingsOfPair> pairs;
  for (std::vector<MeetingsOfPair>& all : of_later) {
    std::ranges::stable_sort(all, std::greater(),
                             [](const MeetingsOfPair& pair) { return pair.meetings.size(); });
    for (MeetingsOfPair& pair : std::span(all).first(std::min(all.size(), kMostEarlier))) {
      if (pair.meetings.size() >= kLeastRatios) pairs.push_back(std::move(pair));
    }
  }
  return pairs;
}

// The ratio of distances of the later scan to those of a map of the earlier drive.
Result<std::optional<double>> ratio_of(const Drive& drive, const Odometry& odometry,
                                       const ScanRange& earlier_run, const Meeting& meeting) {
  SIGHTLINE_ASSIGN(const Visit visit, make_visit(drive, odometry, earlier_run, meeting.earlier, 1));
  SIGHTLINE_ASSIGN(const ThinnedScan scan, read_thinned(drive, meeting.later, ThinnedFor::kMatch));
  const auto match = [&](const std::vector<Eigen::Vector3d>& scaled_m) {
    const LocalMatch found =
        match_locally(visit.grids, scaled_m, odometry.T_map_lidar[meeting.later]);
    return FitAtScale{found.likelihood * found.scored_share, found.is_sure()};
  };
  const std::optional<double> scale = best_scale(scan.to_match_m, match);
  return scale ? std::optional(1.0 / *scale) : std::nullopt;
}

constexpr double kScaleStep = 0.005;
constexpr int kScaleSteps = 8;  // to either side of 1
constexpr double kMostDifference = 0.003;

// Fits by scale, in steps from 1; each scale is matched once.
class FitByScale {
 public:
  FitByScale(const std::vector<Eigen::Vector3d>& points_m, const MatchAtScale& match)
      : points_m_(points_m), match_(match) {}

  // A logarithm: its top is a parabola.
  double at(int step) {
    constexpr double kLeast = 1e-3;  // finite where nothing fits
    return portable_log(std::max(kLeast, match_at(step).fit));
  }

  const FitAtScale& match_at(int step) {
    const auto [known, is_new] = matches_.try_emplace(step);
    if (!is_new) return known->second;
    const double scale = 1.0 + kScaleStep * step;
    std::vector<Eigen::Vector3d> scaled_m;
    for (const Eigen::Vector3d& point_m : points_m_) scaled_m.push_back(scale * point_m);
    return known->second = match_(scaled_m);
  }

 private:
  const std::vector<Eigen::Vector3d>& points_m_;
  const MatchAtScale& match_;
  std::map<int, FitAtScale> matches_;
};

}  // namespace

std::vector<Contradiction> find_contradictions(const Odometry& odometry,
                                               const std::vector<GraphEdge>& loops,
                                               const std::vector<Pose>& T_map_lidar) {
  // By the numbers of the earlier and the later piece.
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<JudgedLoop>> between;
  for (const GraphEdge& loop : loops) {
    const Pose T_from_to = T_map_lidar[loop.from].inverse() * T_map_lidar[loop.to];
    const double off_m = (T_from_to.translation() - loop.T_from_to.translation()).norm();
    const auto [earlier, later] = std::minmax({loop.from, loop.to});
    between[{odometry.piece[earlier], odometry.piece[later]}].push_back({later, earlier, off_m});
  }
  std::vector<Contradiction> found;
  for (auto& [pieces, of_pieces] : between) {
    if (of_pieces.size() < kLeastOff) continue;
    std::ranges::sort(of_pieces);
    add_contradictions(of_pieces, found);
  }
  return found;
}

std::string to_text(const Contradiction& found, const Drive& drive) {
  const auto number = [&](std::uint32_t scan) { return drive.scans[scan].recording_index; };
  const auto name = [&](std::uint32_t scan) { return drive.name_of_part(drive.scans[scan].part); };
  return fmt::format(
      "drive {}, scans {} to {}: {} of {} loops to an earlier visit are more than 0.25 m off, most "
      "at scan {} ({:.2f} m, matched with scan {} of drive {})",
      name(found.later), number(found.first), number(found.last), found.off_count, found.loop_count,
      number(found.later), found.off_m, number(found.earlier), name(found.earlier));
}

void warn_of_contradictions(const PassContext& ctx, const Drive& drive,
                            const std::vector<Contradiction>& found, std::vector<Notice>& notices) {
  if (found.empty()) return;
  const Contradiction& worst = *std::ranges::max_element(found, {}, &Contradiction::off_m);
  notices.push_back(warned(
      ctx,
      {.code = "loops-contradict-poses",
       .text = with_first_places("loop closures contradict the trajectory", found, drive) +
               ". Walls may appear doubled there, because of drift or a false loop at a similar "
               "place. Check these scans, or give poses",
       .count = static_cast<std::uint32_t>(found.size()),
       .first_scan = drive.scans[worst.first].recording_index,
       .last_scan = drive.scans[worst.last].recording_index,
       .amount = worst.off_m,
       .unit = "m"}));
}

Result<std::vector<ScaleDifference>> find_scale_differences(const PassContext& ctx,
                                                            const Drive& drive,
                                                            const Trajectory& trajectory,
                                                            std::size_t from) {
  std::vector<ScaleDifference> found;
  if (drive.later_parts.empty()) return found;
  const Odometry odometry = as_odometry(drive, trajectory);
  const std::vector<ScanRange> runs = ranges_of(odometry.piece);
  for (const MeetingsOfPair& pair : pairs_that_meet(drive, odometry, from)) {
    std::vector<Meeting> meetings;
    for (const std::size_t i : evenly(pair.meetings.size(), kMostScans)) {
      meetings.push_back(pair.meetings[i]);
    }
    SIGHTLINE_ASSIGN(const std::vector<double> ratios,
                     ratios_of_scans(ctx.threads, meetings.size(), [&](std::size_t i) {
                       const ScanRange& earlier_run = runs[odometry.piece[meetings[i].earlier]];
                       return ratio_of(drive, odometry, earlier_run, meetings[i]);
                     }));
    const double ratio = common_ratio(ratios);
    if (ratio == 1.0) continue;
    found.push_back({pair.earlier, pair.later, ratio, static_cast<std::uint32_t>(ratios.size())});
  }
  return found;
}

std::string to_text(const ScaleDifference& found, const Drive& drive) {
  return fmt::format("drive {} measures distances {:.1f} % {} than drive {} (median of {} scans)",
                     drive.name_of_part(found.later), 100.0 * std::abs(found.ratio - 1.0),
                     found.ratio > 1.0 ? "longer" : "shorter", drive.name_of_part(found.earlier),
                     found.scan_count);
}

Result<void> warn_of_scale_differences(const PassContext& ctx, const Drive& drive,
                                       Trajectory& trajectory, std::size_t from) {
  SIGHTLINE_ASSIGN(const std::vector<ScaleDifference> found,
                   find_scale_differences(ctx, drive, trajectory, from));
  if (found.empty()) return {};
  const auto off = [](const ScaleDifference& one) { return std::abs(one.ratio - 1.0); };
  trajectory.notices.push_back(warned(
      ctx, {.code = "drives-differ-in-scale",
            .text = with_first_places("drives measure different distances to the same surfaces",
                                      found, drive) +
                    ". Walls may appear doubled, more so farther from the route. Check the range "
                    "calibration of these sensors, or leave out the wrong drive",
            .count = static_cast<std::uint32_t>(found.size()),
            .amount = 100.0 * off(*std::ranges::max_element(found, {}, off)),
            .unit = "%"}));
  return {};
}

std::optional<double> best_scale(const std::vector<Eigen::Vector3d>& points_m,
                                 const MatchAtScale& match) {
  FitByScale fit(points_m, match);
  int best = 0;
  for (int step = -kScaleSteps; step <= kScaleSteps; step += 2) {
    if (fit.at(step) > fit.at(best)) best = step;
  }
  if (std::abs(best) == kScaleSteps) return std::nullopt;
  for (const int step : {best - 1, best + 1}) {
    if (fit.at(step) > fit.at(best)) best = step;
  }
  if (!fit.match_at(best).is_sure) return std::nullopt;
  const double over_less = fit.at(best) - fit.at(best - 1);
  const double over_more = fit.at(best) - fit.at(best + 1);
  const double sum = over_less + over_more;
  return 1.0 + kScaleStep * (best + (sum > 0.0 ? 0.5 * (over_less - over_more) / sum : 0.0));
}

Result<std::vector<double>> ratios_of_scans(
    int threads, std::size_t count,
    const std::function<Result<std::optional<double>>(std::size_t)>& ratio_of) {
  SIGHTLINE_ASSIGN(const std::vector<std::optional<double>> measured,
                   parallel_results<std::optional<double>>(count, threads, ratio_of));
  std::vector<double> ratios;
  for (const std::optional<double>& ratio : measured) {
    if (ratio) ratios.push_back(*ratio);
  }
  return ratios;
}

double common_ratio(std::vector<double> ratios) {
  if (ratios.size() < kLeastRatios) return 1.0;
  std::ranges::sort(ratios);
  const double off = ratios[ratios.size() / 2] - 1.0;
  if (std::abs(off) <= kMostDifference) return 1.0;
  const double way = off > 0.0 ? 1.0 : -1.0;
  const auto agreeing = std::ranges::count_if(
      ratios, [&](double ratio) { return way * (ratio - 1.0) > 0.5 * kMostDifference; });
  return 4 * static_cast<std::size_t>(agreeing) >= 3 * ratios.size() ? 1.0 + off : 1.0;
}

}  // namespace sightline
