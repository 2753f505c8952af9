#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "formats/base/result.h"
#include "formats/drive/drive.h"

// Given poses of several drives that are one (join-drives); part of estimate-trajectory.

namespace sightline {

// A part of the drive whose given poses put it elsewhere beside earlier parts than its scans show:
// poses of two frames, or of a receiver that was off.
struct PartApart {
  std::uint32_t part = 0;
  std::uint32_t worst = 0;  // scan, by its place in the drive
  double off_m = 0.0;       // of that one
};

// Some scans of each part, where an earlier part was near by the given poses (T_map_lidar, one a
// scan, none where there is none): how much of what a scan sees upright meets what the earlier part
// saw there, at the given pose and at the best pose around it. Apart is a part of which two scans
// and more meet it elsewhere alone, and more than meet it where they are given. Parts that are
// apart are no evidence against later ones. Errors: what reading a scan says.
Result<std::vector<PartApart>> find_parts_apart(const Drive& drive,
                                                const std::vector<std::optional<Pose>>& given);

// The poses but those of these parts.
std::vector<std::optional<Pose>> without_parts(std::vector<std::optional<Pose>> given,
                                               const Drive& drive,
                                               const std::vector<PartApart>& parts);

// One sentence, without its point: which drives, and how far off.
std::string parts_text(const std::vector<PartApart>& parts, const Drive& drive);

}  // namespace sightline
