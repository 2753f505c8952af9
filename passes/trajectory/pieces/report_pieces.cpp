#include "passes/trajectory/pieces/report_pieces.h"

#include <algorithm>
#include <cstdio>
#include <string>

namespace sightline {
namespace {

// Largest share of steps that lead nowhere.
constexpr double kMostLost = 0.25;

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
  const std::uint32_t part = drive.scans[start.scan].part;
  if (part != drive.scans[start.scan - 1].part) {
    return "drive " + drive.name_of_part(part) + " was found nowhere in the drives before it";
  }
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
             reason_text(drive, start) +
             ". How it lies to the pieces before is not known: it is "
             "laid apart from them, at " +
             place_text(odometry.T_map_lidar[start.scan].translation()));
  }
}

void warn_of_unmatched(const PassContext& ctx, const Odometry& odometry) {
  const auto unmatched = std::ranges::count(odometry.is_matched, false) -
                         static_cast<std::ptrdiff_t>(odometry.piece_starts.size());
  if (unmatched > 0) {
    ctx.warn(std::to_string(unmatched) +
             " scans could not be matched to those before them and follow the given poses");
  }
}

}  // namespace sightline
