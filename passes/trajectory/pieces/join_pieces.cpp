#include "passes/trajectory/pieces/join_pieces.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "passes/trajectory/pieces/seek_piece.h"

namespace sightline {
namespace {

constexpr double kJoinSigma_m = 0.2;
constexpr double kJoinSigma_rad = 0.01;
// Distance between pieces besides the sensor's range.
constexpr double kApart_m = 64.0;

// Joins the pieces of one odometry.
class Joiner {
 public:
  Joiner(PassContext& ctx, const Drive& drive, Odometry& odometry, const KnownPieces& known)
      : ctx_(ctx),
        drive_(drive),
        odometry_(odometry),
        ranges_(ranges_of(odometry.piece)),
        fixed_(known.fixed),
        part_(known.number) {
    if (!part_.empty()) return;
    part_.resize(ranges_.size());
    std::iota(part_.begin(), part_.end(), 0U);
  }

  // Joins pieces by the first given pose of each.
  void join_by_given(const GivenPoses& given) {
    std::optional<std::uint32_t> first;
    for (std::uint32_t piece = 0; piece < ranges_.size(); ++piece) {
      for (std::uint32_t k = ranges_[piece].begin; k < ranges_[piece].end; ++k) {
        if (!given[k]) continue;
        if (!is_fixed(piece)) move(piece, *given[k] * odometry_.T_map_lidar[k].inverse());
        if (first) merge(*first, piece);
        if (!first) first = piece;
        break;
      }
    }
  }

  Result<void> join_by_scans() {
    PlaceRecognition places(ctx_, drive_, odometry_, ranges_);
    for (std::uint32_t later = std::max(1U, fixed_); later < ranges_.size(); ++later) {
      SIGHTLINE_ASSIGN(const std::vector<Query> queries,
                       read_queries(drive_, odometry_, ranges_[later]));
      SIGHTLINE_ASSIGN(const std::vector<std::uint32_t> middles, places.before(later, queries));
      for (const std::uint32_t middle : middles) {
        const std::uint32_t earlier = odometry_.piece[middle];
        if (part_[earlier] == part_[later]) continue;
        if (is_fixed(earlier) && is_fixed(later)) continue;
        SIGHTLINE_TRY(join(middle, later, queries));
      }
    }
    return {};
  }

  JoinedPieces separate_rest() {
    JoinedPieces joined;
    joined.edges = std::move(edges_);
    const std::vector<std::uint32_t> numbers = piece_numbers();
    for (const std::uint32_t piece : odometry_.piece) joined.piece.push_back(numbers[piece]);
    double taken_m = -std::numeric_limits<double>::infinity();
    std::vector<bool> is_placed(ranges_.size(), false);
    for (std::uint32_t piece = 0; piece < ranges_.size(); ++piece) {
      if (is_placed[numbers[piece]]) continue;
      is_placed[numbers[piece]] = true;
      if (piece > 0) {
        joined.starts.push_back(odometry_.piece_starts[piece - 1]);
        joined.held.push_back(ranges_[piece].begin);
        if (piece >= fixed_) move_behind(piece, taken_m);
      }
      taken_m = std::max(taken_m, extent_x_m(piece).second);
    }
    return joined;
  }

 private:
  // Joins a piece to an earlier one if it is found around this scan of the earlier one.
  Result<void> join(std::uint32_t middle, std::uint32_t later, const std::vector<Query>& queries) {
    const std::uint32_t earlier = odometry_.piece[middle];
    SIGHTLINE_ASSIGN(const Visit visit,
                     make_visit(drive_, odometry_, ranges_[earlier], middle, ctx_.threads));
    const std::vector<Hypothesis> agreed =
        agreeing(odometry_, look_for(ctx_, visit, odometry_, queries));
    if (agreed.empty()) return {};
    SIGHTLINE_ASSIGN(const bool is_ambiguous,
                     fits_another_level(ctx_, drive_, odometry_, ranges_joined_to(earlier),
                                        {visit, queries, agreed}));
    if (is_ambiguous) return {};
    const auto best = std::ranges::max_element(agreed, {}, &Hypothesis::overlap);
    const Pose T_earlier_later = best->T_map_lidar * odometry_.T_map_lidar[best->scan].inverse();
    SIGHTLINE_ASSIGN(const bool fits,
                     fits_all_along(ctx_, drive_, odometry_, ranges_joined_to(earlier),
                                    {ranges_[later], T_earlier_later, best->scan}));
    if (!fits) return {};
    for (const Hypothesis& one : agreed) {
      edges_.push_back({middle, one.scan, odometry_.T_map_lidar[middle].inverse() * one.T_map_lidar,
                        kJoinSigma_m, kJoinSigma_rad});
    }
    const bool is_later_fixed =
        is_fixed(later) ||
        (!is_fixed(earlier) && first_joined_to(later) < first_joined_to(earlier));
    if (is_later_fixed) {
      move(earlier, T_earlier_later.inverse());
      merge(later, earlier);
    } else {
      move(later, T_earlier_later);
      merge(earlier, later);
    }
    return {};
  }

  // The first of the pieces that a piece is joined to.
  [[nodiscard]] std::ptrdiff_t first_joined_to(std::uint32_t piece) const {
    return std::ranges::find(part_, part_[piece]) - part_.begin();
  }

  [[nodiscard]] std::vector<ScanRange> ranges_joined_to(std::uint32_t piece) const {
    std::vector<ScanRange> joined;
    for (std::size_t other = 0; other < ranges_.size(); ++other) {
      if (part_[other] == part_[piece]) joined.push_back(ranges_[other]);
    }
    return joined;
  }

  // Whether a piece is joined to a fixed one.
  [[nodiscard]] bool is_fixed(std::uint32_t piece) const {
    return std::find(part_.begin(), part_.begin() + fixed_, part_[piece]) != part_.begin() + fixed_;
  }

  // Moves a piece and all that are joined to it.
  void move(std::uint32_t piece, const Pose& T_new_old) {
    for (std::size_t k = 0; k < odometry_.T_map_lidar.size(); ++k) {
      if (part_[odometry_.piece[k]] != part_[piece]) continue;
      odometry_.T_map_lidar[k] = tidied(T_new_old * odometry_.T_map_lidar[k]);
    }
  }

  void merge(std::uint32_t earlier, std::uint32_t later) {
    std::ranges::replace(part_, std::uint32_t{part_[later]}, std::uint32_t{part_[earlier]});
  }

  // The numbers of pieces after joining, in the order of their first scans.
  [[nodiscard]] std::vector<std::uint32_t> piece_numbers() const {
    std::vector<std::uint32_t> numbers;
    std::uint32_t next = 0;
    for (std::size_t piece = 0; piece < part_.size(); ++piece) {
      const std::ptrdiff_t first = first_joined_to(static_cast<std::uint32_t>(piece));
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

  void move_behind(std::uint32_t piece, double taken_m) {
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
  std::uint32_t fixed_;
  std::vector<std::uint32_t> part_;  // pieces with one number are joined
  std::vector<GraphEdge> edges_;
};

// Given poses hold the pieces that have some; the first scan of each other piece is fixed.
void hold_pieces_without_given(const GivenPoses& given, JoinedPieces& joined) {
  std::vector<bool> has_given(joined.held.size() + 1, false);
  for (std::size_t k = 0; k < given.size(); ++k) {
    if (given[k]) has_given[joined.piece[k]] = true;
  }
  if (std::ranges::count(has_given, true) == 0) return;
  std::vector<std::uint32_t> held;
  if (!has_given[0]) held.push_back(0);
  for (std::size_t i = 0; i < joined.held.size(); ++i) {
    if (!has_given[i + 1]) held.push_back(joined.held[i]);
  }
  joined.held = std::move(held);
}

// Largest share of steps that lead nowhere.
constexpr double kMostLost = 0.25;

std::string reason_text(const Drive& drive, const PieceStart& start) {
  const std::uint32_t part = drive.scans[start.scan].part;
  if (part != drive.scans[start.scan - 1].part) {
    return concat("drive ", drive.name_of_part(part), " does not match the drives before it");
  }
  if (start.is_time_jump) {
    const double pause_s = 1e-9 * static_cast<double>(drive.scans[start.scan].stamp_ns -
                                                      drive.scans[start.scan - 1].stamp_ns);
    return fmt::format("it comes {:.1f} s after the scan before it", pause_s);
  }
  if (start.overlap_elsewhere > 0.5 * start.overlap) {
    return fmt::format(
        "it matches several earlier places: {:.0f} and {:.0f} % of its returns from walls match "
        "there",
        100.0 * start.overlap, 100.0 * start.overlap_elsewhere);
  }
  return fmt::format("at most {:.0f} % of its returns from walls match earlier scans",
                     100.0 * start.overlap);
}

std::string place_text(const Eigen::Vector3d& place_m) {
  return fmt::format("({:.1f}, {:.1f}, {:.1f}) m", place_m.x(), place_m.y(), place_m.z());
}

}  // namespace

Result<JoinedPieces> join_pieces(PassContext& ctx, const Drive& drive, const GivenPoses& given,
                                 Odometry& odometry, const KnownPieces& known) {
  Joiner joiner(ctx, drive, odometry, known);
  if (!odometry.piece_starts.empty()) {
    joiner.join_by_given(given);
    SIGHTLINE_TRY(joiner.join_by_scans());
  }
  JoinedPieces joined = joiner.separate_rest();
  hold_pieces_without_given(given, joined);
  return joined;
}

Result<void> check_following(const Drive& drive, const Odometry& odometry) {
  const auto lost = std::ranges::count(odometry.piece_starts, false, &PieceStart::is_time_jump);
  const auto steps = static_cast<double>(odometry.piece.size() - 1);
  if (static_cast<double>(lost) <= kMostLost * steps) return {};
  const auto first = std::ranges::find(odometry.piece_starts, false, &PieceStart::is_time_jump);
  const ScanInfo& scan = drive.scans[first->scan];
  return Error{ErrorCode::kTrajectoryLost,
               fmt::format("{} of {} scans do not match the scans before them, expected at most a "
                           "quarter. The first one: {}",
                           lost, odometry.piece.size() - 1, reason_text(drive, *first)),
               scan.source, concat("scan ", scan.recording_index)};
}

void warn_of_pieces(const PassContext& ctx, const Drive& drive, const Odometry& odometry,
                    const JoinedPieces& joined) {
  for (std::size_t i = 0; i < joined.starts.size(); ++i) {
    const PieceStart& start = joined.starts[i];
    const auto before = static_cast<std::size_t>(start.scan) - 1;
    const ScanInfo& scan = drive.scans[start.scan];
    ctx.warn(fmt::format(
        "drive {}: piece {} of the trajectory begins at scan {}{}, {:.3f} s, after {:.1f} m at {}: "
        "{}. Its position relative to earlier pieces is unknown, so it is placed apart from them, "
        "at {}. Give poses to connect them",
        drive.name, i + 1, scan.recording_index,
        scan.source.empty() ? "" : concat(" (", scan.source, ")"),
        1e-9 * static_cast<double>(scan.stamp_ns), odometry.driven_m[before],
        place_text(odometry.T_map_lidar[before].translation()), reason_text(drive, start),
        place_text(odometry.T_map_lidar[start.scan].translation())));
  }
}

void warn_of_unmatched(const PassContext& ctx, const Odometry& odometry) {
  const auto unmatched = std::ranges::count(odometry.is_matched, false) -
                         static_cast<std::ptrdiff_t>(odometry.piece_starts.size());
  if (unmatched > 0) {
    ctx.warn(
        concat(unmatched, " scans do not match the scans before them; their given poses are used"));
  }
}

}  // namespace sightline
