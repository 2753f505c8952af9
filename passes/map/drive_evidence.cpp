#include "passes/map/drive_evidence.h"

#include <algorithm>
#include <unordered_map>

#include "passes/map/moving_verdict.h"
#include "passes/map/seen_voxels.h"

namespace sightline {
namespace {

// OctoMap's lower clamping threshold, P(occupied) = 0.12.
constexpr double kGoneLogOdds = -2.0;
// A drive saw a voxel standing by two hits and no miss, and looked through it by as much.
constexpr double kSeenLogOdds = 1.6;
// Vehicles and what else is parked leave a gap in these heights above the ground; walls do not.
constexpr double kLowestOfWall_m = 1.0;
constexpr double kHighestOfWall_m = 3.0;
constexpr double kBand_m = 0.5;
constexpr std::uint32_t kAllBands = 0b1111;
// Cars and what lies on the ground tell of no change.
constexpr double kLowestOfChange_m = 0.5;
constexpr double kHighestParked_m = 2.0;
constexpr int kLeastBelow = 4;  // voxels of a column that tell of what is above them

// The evidence of the drives that know a voxel.
struct Opinion {
  double log_odds = 0.0;  // after the latest
  int standing = 0;       // drives
  int gone = 0;
  bool is_gone_at_last = false;
  bool is_known = false;  // by any drive

  void add(double of_drive) {
    is_known = true;
    log_odds = std::clamp(log_odds + of_drive, kGoneLogOdds, kStrongLogOdds);
    standing += of_drive >= kSeenLogOdds ? 1 : 0;
    gone += of_drive <= -kSeenLogOdds ? 1 : 0;
    is_gone_at_last = of_drive <= -kSeenLogOdds;
  }
  [[nodiscard]] bool is_outvoted() const { return standing > 0 && gone > standing; }
};

// Between what some drives say of a voxel and what later ones say.
enum class Change : std::uint8_t {
  kNone,
  kStands,    // stood and stands
  kWent,      // stood, and is looked through
  kCame,      // was looked through, and stands
  kNotSeen,   // stood, and later ones do not know it
  kNotKnown,  // stands, and earlier ones did not know it
};

Change change_of(const Opinion& before, const Opinion& since) {
  const bool stood = before.log_odds >= kSeenLogOdds;
  const bool stands = since.log_odds >= kSeenLogOdds;
  if (stood && stands) return Change::kStands;
  if (stood && since.log_odds <= -kSeenLogOdds) return Change::kWent;
  if (stands && before.log_odds <= -kSeenLogOdds) return Change::kCame;
  if (stood && !since.is_known) return Change::kNotSeen;
  if (stands && !before.is_known) return Change::kNotKnown;
  return Change::kNone;
}

// `below`: voxels of its column further down that came, less those that went.
DriveEvidence::Comparison comparison_of(Change change, int below) {
  if (change == Change::kStands) return DriveEvidence::Comparison::kConfirmed;
  const bool has_changed = change == Change::kWent || change == Change::kCame ||
                           (change == Change::kNotSeen && below <= -kLeastBelow) ||
                           (change == Change::kNotKnown && below >= kLeastBelow);
  return has_changed ? DriveEvidence::Comparison::kChanged : DriveEvidence::Comparison::kNothing;
}

// In which bands of height something stands, of each column.
using StandingBands = std::unordered_map<std::int64_t, std::uint32_t>;

StandingBands standing_bands(const SeenVoxels& seen, const std::vector<Opinion>& opinions) {
  StandingBands bands;
  for (std::size_t v = 0; v < seen.size(); ++v) {
    const double above_m = seen.values()[v].above_ground_m;
    if (opinions[v].log_odds <= 0.0 || above_m < kLowestOfWall_m || above_m >= kHighestOfWall_m) {
      continue;
    }
    bands[column_of(seen.keys()[v])] |=
        1U << static_cast<unsigned>((above_m - kLowestOfWall_m) / kBand_m);
  }
  return bands;
}

}  // namespace

bool DriveEvidence::stands_anyway(std::uint32_t voxel,
                                  const std::vector<std::size_t>& scan_counts) const {
  for (std::size_t drive = 0; drive < drive_count_; ++drive) {
    const auto most_misses = static_cast<std::uint32_t>(scan_counts[drive]);
    if (most_misses == 0) continue;
    if (log_odds(counts(voxel, drive).hits, most_misses) < kStrongLogOdds) return false;
  }
  return true;
}

std::vector<DriveEvidence::Comparison> DriveEvidence::compare(const SeenVoxels& seen,
                                                              std::size_t first_new) const {
  std::vector<Change> changes(seen.size());
  std::unordered_map<std::int64_t, int> below;  // see comparison_of
  for (std::uint32_t v = 0; v < seen.size(); ++v) {
    Opinion before;
    Opinion since;
    for (std::size_t drive = 0; drive < drive_count_; ++drive) {
      const Counts& said = counts(v, drive);
      if (said.hits + said.misses == 0) continue;
      (drive < first_new ? before : since).add(log_odds(said.hits, said.misses));
    }
    changes[v] = change_of(before, since);
    const double above_m = seen.values()[v].above_ground_m;
    if (above_m <= kLowestOfChange_m || above_m > kHighestParked_m) continue;
    if (changes[v] == Change::kCame) ++below[column_of(seen.keys()[v])];
    if (changes[v] == Change::kWent) --below[column_of(seen.keys()[v])];
  }
  std::vector<Comparison> comparisons(seen.size(), Comparison::kNothing);
  for (std::uint32_t v = 0; v < seen.size(); ++v) {
    if (seen.values()[v].above_ground_m <= kHighestParked_m) continue;
    const auto column = below.find(column_of(seen.keys()[v]));
    comparisons[v] = comparison_of(changes[v], column == below.end() ? 0 : column->second);
  }
  return comparisons;
}

void DriveEvidence::conclude(SeenVoxels& seen) const {
  std::vector<Opinion> opinions(seen.size());
  for (std::uint32_t v = 0; v < seen.size(); ++v) {
    for (std::size_t drive = 0; drive < drive_count_; ++drive) {
      const Counts& said = counts(v, drive);
      if (said.hits + said.misses > 0) opinions[v].add(log_odds(said.hits, said.misses));
    }
  }
  const StandingBands bands = standing_bands(seen, opinions);
  for (std::uint32_t v = 0; v < seen.size(); ++v) {
    SeenVoxel& voxel = seen.values()[v];
    const Opinion& opinion = opinions[v];
    voxel.of_drives_log_odds = opinion.log_odds;
    voxel.has_changed = opinion.standing > 0 && opinion.is_gone_at_last;
    if (!opinion.is_outvoted() || opinion.log_odds < 0.0) continue;
    const auto column = bands.find(column_of(seen.keys()[v]));
    const bool is_wall = column != bands.end() && column->second == kAllBands;
    if (!is_wall) voxel.of_drives_log_odds = kGoneLogOdds;
  }
}

}  // namespace sightline
