#pragma once

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

#include "tests/support/real_data.h"

namespace sightline {

struct PosedSet {
  std::string folder;
  std::string pose_file;  // 12 numbers a row, a row a scan
};

// kitti_0005 of SIGHTLINE_DATA with the poses that SIGHTLINE_KITTI_POSES names. Where one of them
// is missing, stderr says which, and that something drawn takes its place.
inline std::optional<PosedSet> posed_kitti_0005() {
  const RealData data = real_data("kitti_0005");
  const char* poses = std::getenv("SIGHTLINE_KITTI_POSES");
  std::string missing = data.missing;
  if (missing.empty() && (poses == nullptr || !std::filesystem::exists(poses))) {
    missing = "SIGHTLINE_KITTI_POSES names no file with the poses of kitti_0005";
  }
  if (missing.empty()) return PosedSet{data.folder.string(), poses};
  std::fprintf(stderr, "%s; a drawn world takes its place\n", missing.c_str());
  return std::nullopt;
}

}  // namespace sightline
