#include "passes/trajectory/pieces/join_pieces.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>

#include "formats/base/parallel.h"
#include "passes/trajectory/pieces/place_widely.h"

namespace sightline {
namespace {

// More steps than this share that lead nowhere are no drive.
constexpr double kMostLost = 0.25;
// Maps of an earlier piece, from its end back: one every so much of the way, of so much of the way
// before and after, of one scan in so much.
constexpr double kVisitEvery_m = 25.0;
constexpr double kVisitReach_m = 20.0;
constexpr double kVisitStep_m = 1.5;
// Scans of the later piece that are looked for: so far from its beginning, and as far from its end.
constexpr double kQueryWays_m[] = {0.0, 2.0, 5.0, 10.0, 20.0, 40.0};
constexpr double kLastQueries_m[] = {0.0, 20.0};
constexpr std::size_t kFewScans = 6;
// What is believed of one scan; and how many must agree, of those that found a place.
constexpr double kLeastOverlap = 0.4;
constexpr double kClearly = 0.08;
constexpr std::size_t kLeastAgreeing = 2;
constexpr double kLeastShareAgreeing = 0.6;
constexpr double kJoinSigma_m = 0.2;
constexpr double kJoinSigma_rad = 0.01;
// Pieces are laid this far apart besides the sensor's range.
constexpr double kApart_m = 64.0;

struct ScanRange {
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
};

std::vector<ScanRange> ranges_of(const std::vector<std::uint32_t>& piece) {
  std::vector<ScanRange> ranges;
  for (std::uint32_t k = 0; k < piece.size(); ++k) {
    if (k == 0 || piece[k] != piece[k - 1]) ranges.push_back({k, k});
    ranges.back().end = k + 1;
  }
  return ranges;
}

// Part of an earlier piece, as a map.
struct Visit {
  std::uint32_t middle = 0;
  LocalGrids grids;
  UprightMap upright{std::numeric_limits<double>::infinity()};
};

Result<Visit> make_visit(const Drive& drive, const Odometry& odometry, const ScanRange& range,
                         std::uint32_t middle) {
  Visit visit;
  visit.middle = middle;
  std::vector<Eigen::Vector3d> points_m;
  const Eigen::Matrix3d level = drive.sensor.T_vehicle_lidar.linear();
  double next_m = odometry.driven_m[middle] - kVisitReach_m;
  for (std::uint32_t k = range.begin; k < range.end; ++k) {
    if (odometry.driven_m[k] > odometry.driven_m[middle] + kVisitReach_m) break;
    if (odometry.driven_m[k] < next_m && k != middle) continue;
    next_m = odometry.driven_m[k] + kVisitStep_m;
    SIGHTLINE_ASSIGN(const ThinnedScan scan, read_thinned(drive, k));
    const Pose& T_map_lidar = odometry.T_map_lidar[k];
    for (const Eigen::Vector3d& point_m : scan.to_map_m) points_m.push_back(T_map_lidar * point_m);
    visit.upright.add(upright_points(scan.to_map_m, level), T_map_lidar, odometry.driven_m[k]);
  }
  visit.grids = local_grids(points_m);
  return visit;
}

// From the end of a piece to its beginning.
std::vector<std::uint32_t> middles_of(const Odometry& odometry, const ScanRange& range) {
  std::vector<std::uint32_t> middles;
  double next_m = std::numeric_limits<double>::infinity();
  for (std::uint32_t k = range.end; k-- > range.begin;) {
    if (odometry.driven_m[k] > next_m) continue;
    middles.push_back(k);
    next_m = odometry.driven_m[k] - kVisitEvery_m;
  }
  return middles;
}

struct Query {
  std::uint32_t scan = 0;
  ThinnedScan thinned;
  std::vector<Eigen::Vector3d> upright_m;
};

std::vector<std::uint32_t> query_scans(const Odometry& odometry, const ScanRange& range) {
  std::vector<std::uint32_t> scans;
  const auto begin = odometry.driven_m.begin();
  const auto at = [&](double driven_m) {
    const auto found = std::lower_bound(begin + range.begin, begin + range.end, driven_m);
    if (found != begin + range.end) scans.push_back(static_cast<std::uint32_t>(found - begin));
  };
  for (const double way_m : kQueryWays_m) at(odometry.driven_m[range.begin] + way_m);
  for (const double way_m : kLastQueries_m) {
    if (way_m <= odometry.driven_m[range.end - 1] - odometry.driven_m[range.begin]) {
      at(odometry.driven_m[range.end - 1] - way_m);
    }
  }
  // Who stands still has scans all the same.
  for (std::uint32_t k = range.begin; scans.size() < kFewScans && k < range.end; ++k) {
    scans.push_back(k);
  }
  std::ranges::sort(scans);
  const auto doubled = std::ranges::unique(scans);
  scans.erase(doubled.begin(), doubled.end());
  return scans;
}

Result<std::vector<Query>> read_queries(const Drive& drive, const Odometry& odometry,
                                        const ScanRange& range) {
  std::vector<Query> queries;
  for (const std::uint32_t scan : query_scans(odometry, range)) {
    Query& query = queries.emplace_back();
    query.scan = scan;
    SIGHTLINE_ASSIGN(query.thinned, read_thinned(drive, scan));
    query.upright_m =
        upright_points(query.thinned.to_match_m, drive.sensor.T_vehicle_lidar.linear());
  }
  return queries;
}

// Where a query's scan lies in the frame of the earlier piece.
struct Hypothesis {
  std::uint32_t scan = 0;
  Pose T_map_lidar = Pose::Identity();
  double overlap = 0.0;
};

std::vector<Hypothesis> look_for(const PassContext& ctx, const Visit& visit,
                                 const Odometry& odometry, const std::vector<Query>& queries) {
  WideSearch search;
  search.least_share = kLeastOverlap;
  const std::vector<std::optional<WidePlacement>> placed =
      parallel_map<std::optional<WidePlacement>>(queries.size(), ctx.threads, [&](std::size_t i) {
        return place_widely({visit.grids, visit.upright},
                            {queries[i].thinned.to_match_m, queries[i].upright_m},
                            odometry.T_map_lidar[visit.middle], search);
      });
  std::vector<Hypothesis> found;
  for (std::size_t i = 0; i < queries.size(); ++i) {
    if (!placed[i] || placed[i]->overlap < kLeastOverlap ||
        placed[i]->overlap < placed[i]->overlap_elsewhere + kClearly) {
      continue;
    }
    found.push_back({queries[i].scan, placed[i]->match.T_map_lidar, placed[i]->overlap});
  }
  return found;
}

// Those that agree with the best on where the later piece lies; none where they are too few.
std::vector<Hypothesis> agreeing(const Odometry& odometry, const std::vector<Hypothesis>& found) {
  std::vector<Hypothesis> most;
  for (const Hypothesis& one : found) {
    const Pose T_earlier_later = one.T_map_lidar * odometry.T_map_lidar[one.scan].inverse();
    std::vector<Hypothesis> with_it = {one};
    for (const Hypothesis& other : found) {
      if (other.scan == one.scan) continue;
      const Pose expected = T_earlier_later * odometry.T_map_lidar[other.scan];
      if (!are_elsewhere(expected, other.T_map_lidar)) with_it.push_back(other);
    }
    if (with_it.size() > most.size()) most = std::move(with_it);
  }
  const double least = kLeastShareAgreeing * static_cast<double>(found.size());
  if (most.size() < kLeastAgreeing || static_cast<double>(most.size()) < least) return {};
  return most;
}

// Joins the pieces of one odometry.
class Joiner {
 public:
  Joiner(PassContext& ctx, const Drive& drive, Odometry& odometry)
      : ctx_(ctx), drive_(drive), odometry_(odometry), ranges_(ranges_of(odometry.piece)) {
    part_.resize(ranges_.size());
    std::iota(part_.begin(), part_.end(), 0U);
  }

  // By the first pose given of each piece.
  void join_by_given(const std::vector<std::optional<Pose>>& given) {
    std::optional<std::uint32_t> first;
    for (std::uint32_t piece = 0; piece < ranges_.size(); ++piece) {
      for (std::uint32_t k = ranges_[piece].begin; k < ranges_[piece].end; ++k) {
        if (!given[k]) continue;
        move(piece, *given[k] * odometry_.T_map_lidar[k].inverse());
        if (first) merge(*first, piece);
        if (!first) first = piece;
        break;
      }
    }
  }

  Result<void> join_by_sight() {
    for (std::uint32_t later = 1; later < ranges_.size(); ++later) {
      SIGHTLINE_ASSIGN(const std::vector<Query> queries,
                       read_queries(drive_, odometry_, ranges_[later]));
      for (std::uint32_t earlier = later; earlier-- > 0;) {
        if (part_[earlier] == part_[later]) continue;
        SIGHTLINE_TRY(join(earlier, later, queries));
      }
    }
    return {};
  }

  JoinedPieces lay_apart() {
    JoinedPieces joined;
    joined.edges = std::move(edges_);
    const std::vector<std::uint32_t> numbers = piece_numbers();
    for (const std::uint32_t piece : odometry_.piece) joined.piece.push_back(numbers[piece]);
    double taken_m = -std::numeric_limits<double>::infinity();
    std::vector<bool> is_laid(ranges_.size(), false);
    for (std::uint32_t piece = 0; piece < ranges_.size(); ++piece) {
      if (is_laid[numbers[piece]]) continue;
      is_laid[numbers[piece]] = true;
      if (piece > 0) {
        joined.starts.push_back(odometry_.piece_starts[piece - 1]);
        joined.held.push_back(ranges_[piece].begin);
        lay_behind(piece, taken_m);
      }
      taken_m = std::max(taken_m, extent_x_m(piece).second);
    }
    return joined;
  }

 private:
  Result<void> join(std::uint32_t earlier, std::uint32_t later,
                    const std::vector<Query>& queries) {
    for (const std::uint32_t middle : middles_of(odometry_, ranges_[earlier])) {
      SIGHTLINE_ASSIGN(const Visit visit,
                       make_visit(drive_, odometry_, ranges_[earlier], middle));
      const std::vector<Hypothesis> agreed =
          agreeing(odometry_, look_for(ctx_, visit, odometry_, queries));
      if (agreed.empty()) continue;
      const auto best = std::ranges::max_element(agreed, {}, &Hypothesis::overlap);
      for (const Hypothesis& one : agreed) {
        edges_.push_back({middle, one.scan,
                          odometry_.T_map_lidar[middle].inverse() * one.T_map_lidar, kJoinSigma_m,
                          kJoinSigma_rad});
      }
      move(later, best->T_map_lidar * odometry_.T_map_lidar[best->scan].inverse());
      merge(earlier, later);
      break;
    }
    return {};
  }

  // Moves all that is joined to a piece.
  void move(std::uint32_t piece, const Pose& T_new_old) {
    for (std::size_t k = 0; k < odometry_.T_map_lidar.size(); ++k) {
      if (part_[odometry_.piece[k]] != part_[piece]) continue;
      odometry_.T_map_lidar[k] = tidied(T_new_old * odometry_.T_map_lidar[k]);
    }
  }

  void merge(std::uint32_t earlier, std::uint32_t later) {
    std::ranges::replace(part_, std::uint32_t{part_[later]}, std::uint32_t{part_[earlier]});
  }

  // Of the pieces that are left, in the order of their first scans.
  [[nodiscard]] std::vector<std::uint32_t> piece_numbers() const {
    std::vector<std::uint32_t> numbers;
    std::uint32_t next = 0;
    for (std::size_t piece = 0; piece < part_.size(); ++piece) {
      const auto first = std::ranges::find(part_, part_[piece]) - part_.begin();
      const bool is_new = first == static_cast<std::ptrdiff_t>(piece);
      numbers.push_back(is_new ? next++ : numbers[static_cast<std::size_t>(first)]);
    }
    return numbers;
  }

  [[nodiscard]] std::pair<double, double> extent_x_m(std::uint32_t piece) const {
    std::pair<double, double> extent_m(std::numeric_limits<double>::infinity(),
                                       -std::numeric_limits<double>::infinity());
    for (std::size_t k = 0; k < odometry_.T_map_lidar.size(); ++k) {
      if (part_[odometry_.piece[k]] != part_[piece]) continue;
      const double x_m = odometry_.T_map_lidar[k].translation().x();
      extent_m = {std::min(extent_m.first, x_m), std::max(extent_m.second, x_m)};
    }
    return extent_m;
  }

  void lay_behind(std::uint32_t piece, double taken_m) {
    const std::uint32_t first = ranges_[piece].begin;
    Pose T_map_first = odometry_.T_map_lidar.front();
    move(piece, T_map_first * odometry_.T_map_lidar[first].inverse());
    const double apart_m = 2.0 * drive_.sensor.max_range_m + kApart_m;
    Pose shift = Pose::Identity();
    shift.translation().x() = taken_m + apart_m - extent_x_m(piece).first;
    move(piece, shift);
  }

  PassContext& ctx_;
  const Drive& drive_;
  Odometry& odometry_;
  std::vector<ScanRange> ranges_;
  std::vector<std::uint32_t> part_;  // pieces with one number are joined
  std::vector<GraphEdge> edges_;
};

std::string scan_text(const Drive& drive, std::uint32_t k) {
  const ScanInfo& scan = drive.scans[k];
  std::string text = "scan " + std::to_string(scan.recording_index);
  if (!scan.source.empty()) text += " (" + scan.source + ")";
  return text;
}

std::string time_text(std::int64_t stamp_ns) {
  char text[48];
  std::snprintf(text, sizeof text, "%.3f s", 1e-9 * static_cast<double>(stamp_ns));
  return text;
}

std::string reason_text(const Drive& drive, const PieceStart& start) {
  char text[192];
  if (start.is_time_jump) {
    const double pause_s = 1e-9 * static_cast<double>(drive.scans[start.scan].stamp_ns -
                                                      drive.scans[start.scan - 1].stamp_ns);
    std::snprintf(text, sizeof text, "it comes %.1f s after the scan before it", pause_s);
  } else if (start.overlap_elsewhere > 0.5 * start.overlap) {
    std::snprintf(text, sizeof text,
                  "it fits several places of what was seen before it, where %.0f and %.0f %% of "
                  "what it sees upright meet that",
                  100.0 * start.overlap, 100.0 * start.overlap_elsewhere);
  } else {
    std::snprintf(text, sizeof text,
                  "at most %.0f %% of what it sees upright meets what was seen before it",
                  100.0 * start.overlap);
  }
  return text;
}

std::string place_text(const Eigen::Vector3d& place_m) {
  char text[96];
  std::snprintf(text, sizeof text, "(%.1f, %.1f, %.1f) m", place_m.x(), place_m.y(), place_m.z());
  return text;
}

}  // namespace

Result<void> check_following(const Drive& drive, const Odometry& odometry) {
  const auto lost = std::ranges::count(odometry.piece_starts, false, &PieceStart::is_time_jump);
  const auto steps = static_cast<double>(odometry.piece.size() - 1);
  if (static_cast<double>(lost) <= kMostLost * steps) return {};
  const auto first = std::ranges::find(odometry.piece_starts, false, &PieceStart::is_time_jump);
  const ScanInfo& scan = drive.scans[first->scan];
  return Error{ErrorCode::kTrajectoryLost,
               std::to_string(lost) + " of " + std::to_string(odometry.piece.size() - 1) +
                   " scans do not follow those before them, expected at most a quarter; of the "
                   "first, " +
                   reason_text(drive, *first),
               scan.source, "scan " + std::to_string(scan.recording_index)};
}

Result<JoinedPieces> join_pieces(PassContext& ctx, const Drive& drive,
                                 const std::vector<std::optional<Pose>>& given,
                                 Odometry& odometry) {
  Joiner joiner(ctx, drive, odometry);
  joiner.join_by_given(given);
  SIGHTLINE_TRY(joiner.join_by_sight());
  return joiner.lay_apart();
}

void warn_of_pieces(const PassContext& ctx, const Drive& drive, const Odometry& odometry,
                    const JoinedPieces& joined) {
  for (std::size_t i = 0; i < joined.starts.size(); ++i) {
    const PieceStart& start = joined.starts[i];
    const auto before = static_cast<std::size_t>(start.scan) - 1;
    char way[64];
    std::snprintf(way, sizeof way, "%.1f m", odometry.driven_m[before]);
    ctx.warn("drive " + drive.name + ": piece " + std::to_string(i + 1) +
             " of the trajectory begins at " + scan_text(drive, start.scan) + ", " +
             time_text(drive.scans[start.scan].stamp_ns) + ", after " + way + " of way at " +
             place_text(odometry.T_map_lidar[before].translation()) + ": " +
             reason_text(drive, start) + ". How it lies to the pieces before is not known: it is "
             "laid apart from them, at " +
             place_text(odometry.T_map_lidar[start.scan].translation()));
  }
}

}  // namespace sightline
