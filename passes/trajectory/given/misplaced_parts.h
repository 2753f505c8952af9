#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"
#include "passes/trajectory/local/estimate_options.h"

namespace sightline {

// A part of the drive whose given poses contradict what earlier parts measured at its places: poses
// of two frames, or of a wrong receiver.
struct MisplacedPart {
  std::uint32_t part = 0;
  std::uint32_t worst = 0;  // scan, by its place in the drive
  double off_m = 0.0;       // of that one
};

// Compares some scans of each part with those of the nearest earlier part by the given poses: the
// overlap of their upright points at the given pose and at the best pose around it. A part is
// misplaced if two scans or more fit only elsewhere, and more than fit where they are given.
// Misplaced parts are not compared with later ones. Errors: those of reading a scan.
Result<std::vector<MisplacedPart>> find_misplaced_parts(const Drive& drive,
                                                        const GivenPoses& given);

// The poses without those of these parts.
GivenPoses without_parts(GivenPoses given, const Drive& drive,
                         const std::vector<MisplacedPart>& parts);

// One sentence, without its full stop: which drives, and how far off.
std::string parts_text(const std::vector<MisplacedPart>& parts, const Drive& drive);

}  // namespace sightline
