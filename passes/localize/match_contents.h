#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "formats/base/hash.h"
#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "passes/pass/tile_digests.h"

namespace sightline {

// What decides how scans are matched by this program's own localizers (PartedWork::content): the
// scans, where they are, and the NDs that they may meet.
class MatchContents {
 public:
  // `trajectory` is in the map's frame; scans reach so far from there. `nds`: of the map. Keeps
  // references to drive and trajectory.
  MatchContents(const Drive& drive, const Trajectory& trajectory, TileDigests nds,
                double longest_m);

  // Of scans of the drive. Nothing where one is not known without reading it.
  [[nodiscard]] std::optional<Digest> of(std::span<const std::optional<std::size_t>> scans) const;

 private:
  const Drive& drive_;
  const Trajectory& trajectory_;
  double longest_m_;
  TileDigests nds_;
};

}  // namespace sightline
