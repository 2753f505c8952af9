#include "passes/trajectory/graph/contradictions.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <span>
#include <utility>

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

JudgedLoop judged(const GraphEdge& loop, const std::vector<Pose>& T_map_lidar) {
  const Pose T_from_to = T_map_lidar[loop.from].inverse() * T_map_lidar[loop.to];
  const double off_m = (T_from_to.translation() - loop.T_from_to.translation()).norm();
  return {std::max(loop.from, loop.to), std::min(loop.from, loop.to), off_m};
}

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

std::string drive_of(const Drive& drive, std::uint32_t scan) {
  return drive.name_of_part(drive.scans[scan].part);
}

}  // namespace

std::vector<Contradiction> find_contradictions(const Odometry& odometry,
                                               const std::vector<GraphEdge>& loops,
                                               const std::vector<Pose>& T_map_lidar) {
  // Loops by pieces: the earlier one's number and the later one's.
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<JudgedLoop>> between;
  for (const GraphEdge& loop : loops) {
    const JudgedLoop of_loop = judged(loop, T_map_lidar);
    between[{odometry.piece[of_loop.earlier], odometry.piece[of_loop.later]}].push_back(of_loop);
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
  return fmt::format(
      "drive {}, scans {} to {}: {} of {} loops to an earlier visit put the scan more than 0.25 m "
      "from its pose, scan {} most ({:.2f} m, by scan {} of drive {})",
      drive_of(drive, found.later), number(found.first), number(found.last), found.off_count,
      found.loop_count, number(found.later), found.off_m, number(found.earlier),
      drive_of(drive, found.earlier));
}

void warn_of_contradictions(const PassContext& ctx, const Drive& drive,
                            const std::vector<Contradiction>& found) {
  if (found.empty()) return;
  ctx.warn(with_first_places("loops contradict the trajectory", found, drive) +
           ". There the map may have its walls twice: the scans bend the way, or places that look "
           "alike were taken for each other");
}

}  // namespace sightline
