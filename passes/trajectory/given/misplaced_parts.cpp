#include "passes/trajectory/given/misplaced_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "formats/grid/point_grid.h"
#include "passes/trajectory/local/local_map.h"
#include "passes/trajectory/local/local_match.h"

namespace sightline {
namespace {

// So many scans of a part are compared, evenly over those near an earlier part.
constexpr std::size_t kQueries = 8;
// Poses of two frames are rarely farther apart than a street is wide; the search reaches as far.
constexpr double kNear_m = 45.0;
// The scans of the earlier part around there.
constexpr double kVisitReach_m = 25.0;
constexpr std::size_t kMostVisitScans = 30;
// Least overlap: steps of one street have 0.65 and more.
constexpr double kLeastOverlap = 0.4;
constexpr double kClearly = 0.15;
constexpr double kElsewhere_m = 1.0;
constexpr std::size_t kLeastElsewhere = 2;

// A scan of a later part and the scan of an earlier one that is nearest to it.
struct Encounter {
  std::uint32_t earlier = 0;
  std::uint32_t later = 0;
};

enum class Verdict { kUnknown, kThere, kElsewhere };

class PartJudge {
 public:
  PartJudge(const Drive& drive, const GivenPoses& given)
      : drive_(drive), given_(given), is_misplaced_(drive.later_parts.size() + 1, false) {
    for (std::uint32_t k = 0; k < given.size(); ++k) {
      if (!given[k]) continue;
      scans_.push_back(k);
      places_m_.push_back(given[k]->translation());
    }
    places_ = PointGrid(places_m_, kNear_m);
  }

  Result<std::vector<MisplacedPart>> run() {
    std::vector<MisplacedPart> misplaced;
    for (std::uint32_t part = 1; part <= drive_.later_parts.size(); ++part) {
      SIGHTLINE_ASSIGN(const std::optional<MisplacedPart> found, judge(part));
      if (!found) continue;
      is_misplaced_[part] = true;
      misplaced.push_back(*found);
    }
    return misplaced;
  }

 private:
  [[nodiscard]] std::vector<Encounter> encounters(std::uint32_t part) const {
    std::vector<Encounter> all;
    for (const std::uint32_t later : scans_) {
      if (drive_.scans[later].part != part) continue;
      const auto is_earlier = [&](const NearPoint& near) {
        const std::uint32_t other = drive_.scans[scans_[near.index]].part;
        return other < part && !is_misplaced_[other];
      };
      const std::optional<NearPoint> near =
          places_.nearest(given_[later]->translation(), kNear_m, is_earlier);
      if (near) all.push_back({scans_[near->index], later});
    }
    std::vector<Encounter> some;
    for (std::size_t i = 0; i < std::min(kQueries, all.size()); ++i) {
      some.push_back(all[i * all.size() / std::min(kQueries, all.size())]);
    }
    return some;
  }

  Result<std::optional<MisplacedPart>> judge(std::uint32_t part) const {
    MisplacedPart worst{part, 0, 0.0};
    std::size_t there = 0;
    std::size_t elsewhere = 0;
    for (const Encounter& encounter : encounters(part)) {
      double off_m = 0.0;
      SIGHTLINE_ASSIGN(const Verdict verdict, compare(encounter, off_m));
      there += verdict == Verdict::kThere ? 1 : 0;
      elsewhere += verdict == Verdict::kElsewhere ? 1 : 0;
      if (verdict != Verdict::kElsewhere || off_m <= worst.off_m) continue;
      worst.worst = encounter.later;
      worst.off_m = off_m;
    }
    if (elsewhere < kLeastElsewhere || elsewhere <= there) return std::optional<MisplacedPart>();
    return std::optional<MisplacedPart>(worst);
  }

  // The scans of the earlier part around one, at most so many, as they are given.
  [[nodiscard]] std::vector<std::uint32_t> visit_scans(std::uint32_t around) const {
    std::vector<std::uint32_t> near;
    places_.visit_within(given_[around]->translation(), kVisitReach_m, [&](const NearPoint& point) {
      const std::uint32_t scan = scans_[point.index];
      if (drive_.scans[scan].part == drive_.scans[around].part) near.push_back(scan);
    });
    std::ranges::sort(near);
    const std::size_t step = near.size() / kMostVisitScans + 1;
    std::vector<std::uint32_t> some;
    for (std::size_t i = 0; i < near.size(); i += step) some.push_back(near[i]);
    return some;
  }

  Result<Verdict> compare(const Encounter& encounter, double& off_m) const {
    const Eigen::Matrix3d level = drive_.sensor.T_vehicle_lidar.linear();
    std::vector<Eigen::Vector3d> points_m;
    UprightMap upright(std::numeric_limits<double>::infinity());
    for (const std::uint32_t scan : visit_scans(encounter.earlier)) {
      SIGHTLINE_ASSIGN(const ThinnedScan thinned, read_thinned(drive_, scan, ThinnedFor::kMap));
      for (const Eigen::Vector3d& p_m : thinned.to_map_m) points_m.push_back(*given_[scan] * p_m);
      upright.add(upright_points(thinned.to_map_m, level), *given_[scan], 0.0);
    }
    SIGHTLINE_ASSIGN(const ThinnedScan sought,
                     read_thinned(drive_, encounter.later, ThinnedFor::kMatch));
    const std::vector<Eigen::Vector3d> upright_m = upright_points(sought.to_match_m, level);
    const Pose& T_map_given = *given_[encounter.later];
    const double here = upright.overlap(upright_m, T_map_given).value_or(0.0);
    if (here >= kLeastOverlap) return Verdict::kThere;
    const LocalGrids grids = local_grids(points_m);
    const std::optional<WidePlacement> wide =
        place_widely({grids, upright}, {sought.to_match_m, upright_m}, T_map_given, {});
    if (!wide ||
        wide->overlap < std::max({kLeastOverlap, here + kClearly, wide->overlap_elsewhere})) {
      return Verdict::kUnknown;
    }
    off_m = (wide->match.T_map_lidar.translation() - T_map_given.translation()).norm();
    return off_m >= kElsewhere_m ? Verdict::kElsewhere : Verdict::kUnknown;
  }

  const Drive& drive_;
  const GivenPoses& given_;
  std::vector<bool> is_misplaced_;    // of each part
  std::vector<std::uint32_t> scans_;  // that have a given pose
  std::vector<Eigen::Vector3d> places_m_;
  PointGrid places_;  // of scans_
};

}  // namespace

Result<std::vector<MisplacedPart>> find_misplaced_parts(const Drive& drive,
                                                        const GivenPoses& given) {
  if (drive.later_parts.empty()) return std::vector<MisplacedPart>{};
  return PartJudge(drive, given).run();
}

GivenPoses without_parts(GivenPoses given, const Drive& drive,
                         const std::vector<MisplacedPart>& parts) {
  for (std::size_t k = 0; k < given.size(); ++k) {
    if (std::ranges::find(parts, drive.scans[k].part, &MisplacedPart::part) != parts.end()) {
      given[k].reset();
    }
  }
  return given;
}

std::string parts_text(const std::vector<MisplacedPart>& parts, const Drive& drive) {
  std::string text = "the given poses of the drives are in different frames: ";
  for (const MisplacedPart& found : parts) {
    text += fmt::format(
        "{}drive {} is {:.1f} m from the pose at which its scans match the drives before it (scan "
        "{})",
        found.part == parts.front().part ? "" : "; ", drive.name_of_part(found.part), found.off_m,
        drive.scans[found.worst].recording_index);
  }
  return text;
}

}  // namespace sightline
