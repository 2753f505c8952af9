// A recording localized by the core of the ROS 2 node, streamed and with the whole map, beside the
// library's own replay:
//
//   ros2_replay CONFIG MAP TRUTH [SECTION=evaluation] [LIMIT_M=0.10]
//
// CONFIG names the recording (a bag in MCAP, or any other), TRUTH its poses. Prints, for each,
// scans with a pose and the share of all that is right to LIMIT_M, how many matches of the streamed
// and the whole map are the same to the bit, and the time of a scan.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "compiler/driver/configuration.h"
#include "formats/foreign/recording/listed_scan_store.h"
#include "formats/foreign/recording/open_recording.h"
#include "formats/foreign/text/pose_file.h"
#include "passes/replay/replay_drive.h"
#include "tests/examples/ros2_replay.h"

namespace {

using namespace sightline;

struct Drive {
  Recording recording;
  std::vector<ListedScan> scans;  // without poses
  std::vector<Pose> truth_world;
};

Result<Drive> read_drive(const std::string& config_file, const std::string& section,
                         const std::string& truth_file) {
  SIGHTLINE_ASSIGN(const CompileConfig config, load_compile_config(config_file, {}));
  const RecordingOptions& options =
      section == "localization" ? config.localization : config.evaluation;
  Drive drive;
  SIGHTLINE_ASSIGN(drive.recording, list_recording(options));
  SIGHTLINE_ASSIGN(const std::vector<PoseRow> rows, read_poses(truth_file, PoseFormat::kAuto));
  for (std::size_t i = 0; i < drive.recording.scans.size() && i < rows.size(); ++i) {
    const RecordedScan& scan = drive.recording.scans[i];
    drive.scans.push_back({scan.stamp_ns, scan.name, std::nullopt});
    drive.truth_world.push_back(rows[i].T_world_vehicle);
  }
  return drive;
}

bool is_right(const Pose& found, const Pose& truth, double limit_m) {
  return (found.translation() - truth.translation()).norm() <= limit_m;
}

void print(const char* name, std::size_t posed, std::size_t right, std::size_t count) {
  std::printf("%s posed %zu right %zu of %zu share %.4f\n", name, posed, right, count,
              static_cast<double>(right) / static_cast<double>(count));
}

Result<void> run_library(const Drive& drive, const NodeReplayOptions& options) {
  SIGHTLINE_ASSIGN(JoinedMaps maps, JoinedMaps::open({options.map_file}, {}));
  const std::shared_ptr<const ScanStore> store = listed_scan_store(drive.recording);
  ReplayOptions replayed;
  replayed.T_world_start = options.T_world_start;
  replayed.limit_m = options.limit_m;
  SIGHTLINE_ASSIGN(
      const ReplayedDrive found,
      replay_drive(PassContext{}, replayed, {maps, drive.recording.sensor, *store, drive.scans}));
  std::size_t posed = 0, right = 0;
  for (std::size_t i = 0; i < found.scans.size(); ++i) {
    if (found.scans[i].state != ScanState::kLocalized) continue;
    ++posed;
    right += is_right(found.scans[i].T_world_vehicle, drive.truth_world[i], options.limit_m);
  }
  print("library", posed, right, drive.scans.size());
  return {};
}

Result<std::vector<NodeScan>> run_node(const char* name, const Drive& drive,
                                       const NodeReplayOptions& options) {
  const std::shared_ptr<const ScanStore> store = listed_scan_store(drive.recording);
  SIGHTLINE_ASSIGN(std::vector<NodeScan> found,
                   replay_in_node(options, *store, drive.scans, drive.recording.sensor));
  std::size_t posed = 0, right = 0;
  std::vector<double> times_ms;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (!found[i].has_pose) continue;
    ++posed;
    right += is_right(found[i].T_world_vehicle, drive.truth_world[i], options.limit_m);
    times_ms.push_back(found[i].exe_time_ms);
  }
  std::ranges::sort(times_ms);
  print(name, posed, right, drive.scans.size());
  if (!times_ms.empty()) {
    std::printf("%s ms median %.3f p99 %.3f\n", name, times_ms[times_ms.size() / 2],
                times_ms[times_ms.size() * 99 / 100]);
  }
  return found;
}

bool is_same(const sightline_match& a, const sightline_match& b) {
  return std::ranges::equal(a.T_world_vehicle, b.T_world_vehicle) &&
         std::ranges::equal(a.covariance, b.covariance) &&
         std::ranges::equal(a.information, b.information) &&
         std::ranges::equal(a.protection_m, b.protection_m) && a.score == b.score &&
         a.work == b.work && a.integrity == b.integrity && a.raised_met == b.raised_met;
}

Result<void> run(int argc, char** argv) {
  const std::string section = argc > 4 ? argv[4] : "evaluation";
  SIGHTLINE_ASSIGN(const Drive drive, read_drive(argv[1], section, argv[3]));
  if (drive.scans.empty()) return Error{ErrorCode::kEmptyDirectory, "no scans", argv[1]};
  NodeReplayOptions options;
  options.map_file = argv[2];
  options.limit_m = argc > 5 ? std::atof(argv[5]) : 0.10;
  options.T_world_start = drive.truth_world.front();
  SIGHTLINE_TRY(run_library(drive, options));
  SIGHTLINE_ASSIGN(const std::vector<NodeScan> streamed, run_node("streamed", drive, options));
  options.holds_whole_map = true;
  SIGHTLINE_ASSIGN(const std::vector<NodeScan> whole, run_node("whole", drive, options));
  std::size_t same = 0;
  for (std::size_t i = 0; i < streamed.size(); ++i) {
    same += is_same(streamed[i].match, whole[i].match) ? 1 : 0;
  }
  std::printf("same bits %zu of %zu\n", same, streamed.size());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4 || argc > 6) {
    std::fprintf(stderr, "usage: %s CONFIG MAP TRUTH [SECTION=evaluation] [LIMIT_M=0.10]\n",
                 argv[0]);
    return 64;
  }
  const Result<void> result = run(argc, argv);
  if (result) return 0;
  std::fprintf(stderr, "%s\n", to_string(result.error()).c_str());
  return 1;
}
