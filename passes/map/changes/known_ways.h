#pragma once

#include <cstddef>
#include <vector>

#include "formats/drive/drive.h"
#include "formats/drive/trajectory.h"
#include "formats/grid/point_grid.h"

namespace sightline {

// The ways that the drives of an earlier map laid; part of choose-scans. Keeps references to the
// drive and its trajectory.
class KnownWays {
 public:
  // `earlier`: the scans that were laid, by their places in the drive.
  KnownWays(const Drive& drive, const Trajectory& trajectory, std::vector<std::size_t> earlier);

  // Whether so many drives passed a scan's place in its direction, one of them on its way, from
  // behind it to ahead.
  [[nodiscard]] bool know(std::size_t scan, int drives) const;

 private:
  const Drive& drive_;
  const Trajectory& trajectory_;
  std::vector<std::size_t> earlier_;
  PointGrid grid_;  // of their places
};

}  // namespace sightline
