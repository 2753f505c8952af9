#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "passes/map/seen_voxels.h"

namespace sightline {

// Evidence of several drives for the voxels of one place; part of remove-moving. The log odds of
// the drives are added in their order, and clamped after each to OctoMap's thresholds (Hornung et
// al., Autonomous Robots 34, 2013, section 3.2; "Several drives" in schemas/definitions.md).
class DriveEvidence {
 public:
  explicit DriveEvidence(std::size_t drive_count) : drive_count_(drive_count) {}

  void add_hit(std::uint32_t voxel, std::size_t drive) { ++counts(voxel, drive).hits; }
  void add_miss(std::uint32_t voxel, std::size_t drive) { ++counts(voxel, drive).misses; }

  // As stands_anyway() of moving_verdict.h. `scan_counts`: scans near it, of each drive.
  [[nodiscard]] bool stands_anyway(std::uint32_t voxel,
                                   const std::vector<std::size_t>& scan_counts) const;

  // Fills of_drives_log_odds and has_changed. After mark_ground.
  void conclude(SeenVoxels& seen) const;

  // What the drives from `first_new` on say of a voxel that those before knew, or did not know.
  enum class Comparison : std::uint8_t { kNothing, kConfirmed, kChanged };

  // Of each voxel; nothing up to 2 m above the ground, where things are parked. Confirmed: it stood
  // before and stands. Changed: it stood and is looked through, or the reverse. Where one side did
  // not see it, the evidence of both for its column further down decides. After mark_ground.
  [[nodiscard]] std::vector<Comparison> compare(const SeenVoxels& seen,
                                                std::size_t first_new) const;

 private:
  struct Counts {
    std::uint32_t hits = 0;
    std::uint32_t misses = 0;
  };
  Counts& counts(std::uint32_t voxel, std::size_t drive) {
    const std::size_t at = voxel * drive_count_ + drive;
    if (at >= counts_.size()) counts_.resize((voxel + 1) * drive_count_);
    return counts_[at];
  }
  [[nodiscard]] const Counts& counts(std::uint32_t voxel, std::size_t drive) const {
    return counts_[voxel * drive_count_ + drive];
  }

  std::size_t drive_count_;
  std::vector<Counts> counts_;  // by voxel, then by drive
};

}  // namespace sightline
