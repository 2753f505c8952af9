// What becomes of a trajectory where scans are missing, out of order or of another day, and where a
// hand turns the sensor: a recorded street with scans taken out, and towns that are walked through.
// One row a case. A scan is right within 0.3 m and 1 degree of the truth, seen from the first scan
// of its piece: for the street the trajectory of the whole recording, for towns the true one.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "examples/town/drive/drive.h"
#include "formats/base/random.h"
#include "formats/foreign/recording/open_recording.h"
#include "formats/geometry.h"
#include "passes/ingest/ingest.h"
#include "passes/trajectory/estimate_trajectory.h"
#include "tests/bench/bench_tools.h"

namespace {

using namespace sightline;
constexpr double kRight_m = 0.3;
constexpr double kRight_deg = 1.0;
constexpr double kDay_s = 86400.0;

class ChosenScans : public ScanStore {
 public:
  ChosenScans(const Drive& drive, std::vector<std::size_t> chosen,
              std::vector<std::int64_t> stamps_ns)
      : drive_(drive), chosen_(std::move(chosen)), stamps_ns_(std::move(stamps_ns)) {}
  Result<Scan> read(std::size_t index) const override {
    Result<Scan> scan = drive_.store->read(chosen_[index]);
    if (scan) scan->stamp_ns = stamps_ns_[index];
    return scan;
  }

 private:
  Drive drive_;
  std::vector<std::size_t> chosen_;
  std::vector<std::int64_t> stamps_ns_;
};

struct Case {
  std::string name;
  std::vector<std::size_t> scans;    // of the whole drive
  std::vector<double> times_s = {};  // empty: a tenth of a second from each to the next
};

Drive drive_of(const Drive& whole, const Case& made) {
  Drive drive = whole;
  drive.name = made.name;
  drive.scans.clear();
  std::vector<std::int64_t> stamps_ns;
  for (std::size_t i = 0; i < made.scans.size(); ++i) {
    ScanInfo scan = whole.scans[made.scans[i]];
    const double time_s = made.times_s.empty() ? 0.1 * static_cast<double>(i) : made.times_s[i];
    scan.recording_index = static_cast<std::uint32_t>(i);
    scan.stamp_ns = std::llround(1e9 * time_s);
    scan.T_world_vehicle = std::nullopt;
    stamps_ns.push_back(scan.stamp_ns);
    drive.scans.push_back(scan);
  }
  drive.store = std::make_shared<const ChosenScans>(whole, made.scans, stamps_ns);
  return drive;
}

struct Outcome {
  std::uint32_t pieces = 0;
  std::size_t wrong = 0;
  double largest_m = 0.0;
  double largest_deg = 0.0;
  double least_overlap = 1.0;
};

Outcome compare(const Trajectory& found, const std::vector<Pose>& truth) {
  Outcome outcome;
  std::vector<std::size_t> first;
  for (std::size_t i = 0; i < found.poses.size(); ++i) {
    const TrajectoryPose& pose = found.poses[i];
    if (pose.piece == first.size()) first.push_back(i);
    if (pose.overlap) outcome.least_overlap = std::min(outcome.least_overlap, *pose.overlap);
    const std::size_t begin = first[pose.piece];
    const Pose T_truth_found = truth[begin] * found.poses[begin].T_map_vehicle.inverse();
    const Pose off = truth[i].inverse() * T_truth_found * pose.T_map_vehicle;
    const double off_deg = rotation_angle_rad(off.linear()) * 180.0 / std::numbers::pi;
    outcome.largest_m = std::max(outcome.largest_m, off.translation().norm());
    outcome.largest_deg = std::max(outcome.largest_deg, off_deg);
    if (off.translation().norm() > kRight_m || off_deg > kRight_deg) ++outcome.wrong;
  }
  outcome.pieces = static_cast<std::uint32_t>(first.size());
  return outcome;
}

std::vector<Pose> run(const Drive& drive, const std::vector<Pose>& truth) {
  std::vector<std::string> warnings;
  PassContext ctx;
  ctx.threads = 2;
  ctx.warning_sink = [&](const std::string& text) { warnings.push_back(text); };
  const double begin_s = cpu_s();
  const Result<Trajectory> found = estimate_trajectory(ctx, {}, drive);
  const double took_s = cpu_s() - begin_s;
  std::vector<Pose> poses;
  if (!found) {
    std::printf("%-22s %s\n", drive.name.c_str(), to_string(found.error()).c_str());
  } else {
    for (const TrajectoryPose& pose : found->poses) poses.push_back(pose.T_map_vehicle);
    const Outcome outcome = compare(*found, truth.empty() ? poses : truth);
    std::printf(
        "%-22s %4zu scans %2u pieces %3zu wrong | largest %6.2f m %6.2f deg | least overlap "
        "%.2f | loops %u | cpu %.1f s\n",
        drive.name.c_str(), drive.scans.size(), outcome.pieces, outcome.wrong, outcome.largest_m,
        outcome.largest_deg, outcome.least_overlap, found->loop_edges, took_s);
  }
  for (const std::string& warning : warnings) std::printf("    warning: %s\n", warning.c_str());
  std::fflush(stdout);
  return poses;
}

std::vector<Case> cases_of(std::size_t count) {
  std::vector<std::size_t> all(count);
  std::iota(all.begin(), all.end(), std::size_t{0});
  std::vector<Case> cases;
  const auto with_and_without_times = [&](Case made) {
    cases.push_back(made);
    made.name += ", stamps";
    for (const std::size_t scan : made.scans) {
      made.times_s.push_back(0.1 * static_cast<double>(scan));
    }
    cases.push_back(std::move(made));
  };
  // Scans from 60 on are 0.42 m apart, later ones 0.6 m.
  for (const auto& [name, end] : {std::pair<const char*, std::size_t>{"hole of 4 m", 70},
                                  {"hole of 8 m", 80},
                                  {"hole of 17 m", 100},
                                  {"hole of 35 m", 131}}) {
    Case made{name, {}};
    for (const std::size_t scan : all)
      if (scan < 60 || scan >= end) made.scans.push_back(scan);
    with_and_without_times(made);
  }
  Case twelfth{"every 12th scan", {}};
  for (std::size_t scan = 0; scan < count; scan += 12) twelfth.scans.push_back(scan);
  with_and_without_times(twelfth);
  Case shuffled{"shuffled", all};
  Random random(1);
  for (std::size_t i = count; i > 1; --i) {
    std::swap(shuffled.scans[i - 1], shuffled.scans[random.next() % i]);
  }
  cases.push_back(shuffled);
  Case halves{"halves a day apart", all};
  for (const std::size_t scan : all) {
    halves.times_s.push_back(0.1 * static_cast<double>(scan) + (2 * scan < count ? 0.0 : kDay_s));
  }
  cases.push_back(halves);
  Case twice{"twice, a day apart", all};
  twice.scans.insert(twice.scans.end(), all.begin(), all.end());
  for (std::size_t i = 0; i < twice.scans.size(); ++i) {
    twice.times_s.push_back(0.1 * static_cast<double>(i) + (i < count ? 0.0 : kDay_s));
  }
  cases.push_back(twice);
  Case reversed{"backwards", all};
  std::ranges::reverse(reversed.scans);
  cases.push_back(reversed);
  Case standing{"standing for 30 scans", {}};
  for (const std::size_t scan : all) {
    standing.scans.insert(standing.scans.end(), scan == 60 ? 30 : 1, scan);
  }
  cases.push_back(standing);
  return cases;
}

int run_street(const std::string& scans, const std::string& sensor, const std::string& only) {
  RecordingOptions options;
  options.scans = scans;
  options.sensor = sensor;
  const Result<Recording> recording = open_recording(options, 2);
  if (!recording) {
    std::fprintf(stderr, "%s\n", to_string(recording.error()).c_str());
    return 1;
  }
  PassContext ctx;
  ctx.threads = 2;
  const Result<Drive> drive = ingest(ctx, {}, *recording);
  if (!drive) return 1;
  std::vector<std::size_t> all(drive->scans.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  const std::vector<Pose> truth = run(drive_of(*drive, {"whole", all}), {});
  if (truth.empty()) return 1;
  for (const Case& made : cases_of(drive->scans.size())) {
    if (!only.empty() && made.name.find(only) == std::string::npos) continue;
    std::vector<Pose> true_poses;
    for (const std::size_t scan : made.scans) true_poses.push_back(truth[scan]);
    run(drive_of(*drive, made), true_poses);
  }
  return 0;
}

int run_town(std::uint64_t seed, double length_m, int beams, bool by_hand) {
  const Result<town::Town> made = town::make_town({seed, std::max(length_m, 200.0)});
  const Result<SensorProfile> sensor = town::town_sensor(beams);
  if (!made || !sensor) return 1;
  town::DriveOptions options = town::usual_drive(made->options, 0, *sensor);
  options.length_m = length_m;
  if (by_hand) options = town::carried_by_hand(options);
  const Result<town::DriveSimulator> simulator = town::DriveSimulator::make(*made, options);
  if (!simulator) return 1;
  const std::vector<Pose>& truth = simulator->T_town_vehicle();
  Drive drive = town::recorded(*simulator, "", truth, 2);
  drive.name = "town " + std::to_string(seed) + ", " + std::to_string(beams) + " beams" +
               (by_hand ? ", by hand" : "");
  for (ScanInfo& scan : drive.scans) scan.T_world_vehicle = std::nullopt;
  run(drive, truth);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  std::string scans;
  std::string sensor = "hdl-64e";
  std::string only;
  std::vector<std::uint64_t> seeds;
  double length_m = 100.0;
  int beams = 16;
  bool by_hand = false;
  CLI::App app("Takes scans out of a recording, turns sensors, and measures where that leads.");
  app.add_option("--scans", scans, "a recording without poses: kitti_0005");
  app.add_option("--sensor", sensor);
  app.add_option("--only", only, "cases whose name holds this");
  app.add_option("--towns", seeds, "seeds of towns");
  app.add_option("--length-m", length_m);
  app.add_option("--beams", beams);
  app.add_flag("--by-hand", by_hand);
  CLI11_PARSE(app, argc, argv);
  if (!scans.empty() && run_street(scans, sensor, only) != 0) return 1;
  for (const std::uint64_t seed : seeds) {
    if (run_town(seed, length_m, beams, by_hand) != 0) return 1;
  }
  return 0;
}
