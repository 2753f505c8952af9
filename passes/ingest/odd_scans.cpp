#include "passes/ingest/odd_scans.h"

#include <algorithm>
#include <cstddef>

#include "formats/base/parallel.h"

namespace sightline {
namespace {

// A scan agrees with another one less than this share of what its neighbours do: in widened views,
// in which turned cells agree as well as others, and in fine ones.
constexpr double kContradictsWide = 0.8;
constexpr double kContradicts = 0.65;
// Neighbours that agree less are too far apart or see too little to judge others.
constexpr double kNeighboursAgree = 0.4;
// Consecutive scans that agree more are not looked at.
constexpr double kAgrees = 0.75;
constexpr std::size_t kLongestRun = 3;

class OddFinder {
 public:
  OddFinder(const std::vector<TopView>& views,
            const std::vector<std::optional<Pose>>& T_world_sensor, int threads)
      : views_(views), poses_(T_world_sensor), is_odd_(views.size(), false) {
    next_ = parallel_map<std::optional<Agreement>>(
        views.size() - 1, threads, [&](std::size_t k) { return compared(k, k + 1, kAhead_rad); });
  }

  std::vector<bool> run() {
    const std::size_t count = views_.size();
    if (is_odd_end(0, 1, 2, 3)) is_odd_[0] = true;
    if (is_odd_end(count - 1, count - 2, count - 3, count - 4)) is_odd_[count - 1] = true;
    std::size_t before = is_odd_[0] ? 1 : 0;
    while (before + 2 < count) {
      const std::size_t run = length_of_odd_run(before);
      for (std::size_t k = before + 1; k <= before + run; ++k) is_odd_[k] = true;
      before += run + 1;
    }
    return is_odd_;
  }

 private:
  static constexpr double kAhead_rad = 0.12;
  static constexpr double kSwing_rad = 1.75;

  [[nodiscard]] std::optional<Agreement> compared(std::size_t a, std::size_t b,
                                                  double turn_rad) const {
    AgreementSearch search;
    search.turn_rad = turn_rad;
    search.reach_m *= static_cast<double>(std::min<std::size_t>(2, b - a));
    if (poses_[a] && poses_[b]) {
      search.around.push_back(plane_motion(poses_[a]->inverse() * *poses_[b]));
    }
    return agreement(views_[a], views_[b], search);
  }

  static bool is_less(const std::optional<Agreement>& found, const Agreement& agreed) {
    return found && found->wide < kContradictsWide * agreed.wide &&
           found->fine < kContradicts * agreed.fine;
  }

  // Also with a sensor that swung aside.
  [[nodiscard]] bool contradicts(std::size_t k, std::size_t other, const Agreement& agreed) const {
    const auto [a, b] = std::minmax(k, other);
    if (b == a + 1 && !is_less(next_[a], agreed)) return false;
    return is_less(compared(a, b, kSwing_rad), agreed);
  }

  // Of scans after `before`; 0 where they agree.
  [[nodiscard]] std::size_t length_of_odd_run(std::size_t before) const {
    if (!next_[before] || next_[before]->fine >= kAgrees * usual_near(before)) return 0;
    for (std::size_t run = 1; run <= kLongestRun && before + run + 1 < views_.size(); ++run) {
      if (is_odd_run(before, before + run + 1)) return run;
    }
    return 0;
  }

  [[nodiscard]] bool is_odd_run(std::size_t before, std::size_t after) const {
    const Agreement agreed = compared(before, after, kAhead_rad).value_or(Agreement{});
    if (agreed.fine < kNeighboursAgree) return false;
    for (std::size_t k = before + 1; k < after; ++k) {
      if (!contradicts(k, before, agreed) || !contradicts(k, after, agreed)) return false;
    }
    return true;
  }

  [[nodiscard]] bool is_odd_end(std::size_t end, std::size_t second, std::size_t third,
                                std::size_t fourth) const {
    if (views_.size() < 4) return false;
    const Agreement near = next_[std::min(second, third)].value_or(Agreement{});
    const Agreement far = next_[std::min(third, fourth)].value_or(Agreement{});
    const Agreement agreed{std::min(near.wide, far.wide), std::min(near.fine, far.fine)};
    return agreed.fine >= kNeighboursAgree && contradicts(end, second, agreed) &&
           contradicts(end, third, agreed);
  }

  // The median of consecutive scans around.
  [[nodiscard]] double usual_near(std::size_t k) const {
    constexpr std::size_t kAround = 5;
    std::vector<double> near;
    for (std::size_t i = k < kAround ? 0 : k - kAround; i < std::min(next_.size(), k + kAround);
         ++i) {
      if (next_[i]) near.push_back(next_[i]->fine);
    }
    if (near.empty()) return 0.0;
    std::ranges::nth_element(near, near.begin() + static_cast<std::ptrdiff_t>(near.size() / 2));
    return near[near.size() / 2];
  }

  const std::vector<TopView>& views_;
  const std::vector<std::optional<Pose>>& poses_;
  std::vector<bool> is_odd_;
  std::vector<std::optional<Agreement>> next_;  // how each scan agrees with the next one
};

}  // namespace

std::vector<std::optional<Pose>> level_sensor_poses(const Recording& recording) {
  const Eigen::Translation3d in_vehicle(recording.sensor.T_vehicle_lidar.translation());
  std::vector<std::optional<Pose>> poses;
  for (const RecordedScan& scan : recording.scans) {
    poses.emplace_back();
    if (scan.T_world_vehicle) poses.back() = *scan.T_world_vehicle * in_vehicle;
  }
  return poses;
}

std::vector<bool> odd_scans(const std::vector<TopView>& views,
                            const std::vector<std::optional<Pose>>& T_world_sensor, int threads) {
  constexpr std::size_t kFewest = 3;
  if (views.size() < kFewest) return std::vector<bool>(views.size(), false);
  return OddFinder(views, T_world_sensor, threads).run();
}

}  // namespace sightline
