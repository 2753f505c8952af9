#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "compiler/init/find_scans.h"
#include "formats/foreign/recording/recording.h"

namespace sightline {

// A key of the configuration that was guessed, and what the guess is made of.
struct GuessedKey {
  std::string key;  // "poses"
  std::string value;
  std::string reason;  // sentences for the person who checks it
};

// One drive as it would stand in a configuration.
struct FoundDrive {
  std::filesystem::path scans;
  std::size_t scan_count = 0;
  std::vector<GuessedKey> keys;  // paths are absolute; without `scans`
  std::string poses;             // of the file chosen; empty: there are none that fit
  // Positions along the poses, for whether two drives meet; empty where there are none.
  std::vector<Eigen::Vector3d> positions_m;
  double length_m = 0.0;
  std::vector<std::string> other_topics;  // of a bag: more scans of the same vehicle
  std::string contents;                   // "154 files, 0000000000.pcd to 0000000153.pcd"
};

// `sensor`: a profile or a file of beams that the user named; empty: it is recognized.
// Opens scans with each file of poses and times that lies near, keeps what fits them and says why.
// Errors, where they are no drive that compiles: those of list_recording and read_listed_scan, and
// unsupported-format (half of the points within 0.5 m of the origin, or beyond 2 km).
Result<FoundDrive> look_at_drive(const FoundScans& found, const std::string& sensor = "");

}  // namespace sightline
