#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "examples/town/whole/town.h"
#include "formats/base/result.h"

namespace sightline::town {

// A drive that does not cover the whole route.
struct PartialDrive {
  int drive = 0;
  double from_m = 0.0;  // of the driven line
  double to_m = 0.0;
};

struct WriteTownOptions {
  TownOptions town;
  std::filesystem::path out;
  int drives = 2;      // for localization, 0 to 9, beside the one that maps
  int beams = 16;      // 16, 32, 64, 128
  std::string sensor;  // a profile or a file instead; empty: the beams
  double spacing_m = 1.0;
  bool is_swept = false;    // as in DriveOptions: a bag instead of scans
  bool is_by_hand = false;  // carried_by_hand() instead of spacing_m
  double traffic = 1.0;     // of every drive, as in DriveOptions
  double missing_share = 0.0;
  bool has_fog = false;      // as in DriveOptions
  double covered_deg = 0.0;  // as in DriveOptions
  // Every so many metres of each drive what a scan constrains is written; 0: nowhere.
  double constraints_m = 0.0;
  std::vector<PartialDrive> parts;  // drives that are not here cover the route
  std::vector<int> in_next_lane;    // drives in the oncoming lane
  std::vector<int> back;            // drives from the end to the beginning
  Eigen::Vector2d origin_world_m = Eigen::Vector2d::Zero();  // where the driven line begins
  bool replaces = false;                                     // an earlier town in the same place
  int threads = 0;                                           // 0: all there are
};

// Writes recordings as they come from a vehicle:
//   out/mapping/scans/000000.pcd ...  binary PCD, x y z intensity, sensor frame
//   out/mapping/poses.tum             T_world_vehicle, disturbed; poses_true.tum: the truth
//   out/drive_1/..., out/drive_2/...  the same with true poses in poses.tum
// Drives that are swept: out/mapping/drive.mcap in place of scans/ (see write_bag), poses beside
// it.
// Of a hard world also:
//   out/places.csv                    from_m,to_m,kind: the kinds of places along the route
//   out/mapping/scans.csv ...         scan,driven_m,kind: where on the route each scan is
//   out/mapping/constraints.csv ...   see Constraint: scan,driven_m,kind,kept_ahead,kept_left,
//                                     sigma_ahead_m,sigma_left_m; if requested
// and the bags of swept drives have motion sensors (see write_bag).
//   out/town.json                     what was made; written last, so it marks a whole town
// The same options give the same bytes for any number of threads.
// Errors: bad-argument, output-exists, disk-full, cannot-write, those of town_sensor.
Result<void> write_town(const WriteTownOptions& options);

}  // namespace sightline::town
