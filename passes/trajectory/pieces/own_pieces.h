#pragma once

#include <cstddef>
#include <vector>

#include "formats/annotation/sites.h"
#include "formats/drive/trajectory.h"

// The pieces of a drive that is laid into a map; part of align-drive.

namespace sightline {

// Scans whose own poses are known relative to each other.
struct OwnPiece {
  std::size_t begin = 0;
  std::size_t end = 0;
  [[nodiscard]] std::size_t size() const { return end - begin; }
};
// Stretches of one piece; a piece that was interrupted by another is several.
std::vector<OwnPiece> pieces_of_drive(const Trajectory& own);

// Puts a piece that is found nowhere where no site and no other scan is, 2 km beyond along x.
void lay_aside(const std::vector<Pose>& T_own_lidar, const OwnPiece& piece, const Sites& sites,
               std::vector<Pose>& T_map_lidar);

}  // namespace sightline
