// Global localization: where in a map of a generated world a scan was taken, without a start. Maps
// are of drive 0, scans of another drive. One row a world:
//   right     found within 0.5 m and 5 degrees
//   refused   no place, or two places alike
//   wrong     found elsewhere
//   foreign   scans of another world of this kind that were found, of all
//   seconds   on `--threads`: median, 95th percentile
//   met       share of upright points that meet the map where right
//   ratio     likelihood in the best other place over that found: where right, and where wrong

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "formats/base/files/atomic_file.h"
#include "formats/foreign/recording/listed_scan_store.h"
#include "formats/foreign/recording/open_recording.h"
#include "formats/foreign/text/pose_file.h"
#include "formats/map/map_writer.h"
#include "passes/replay/find_place.h"
#include "passes/replay/pose_rows.h"
#include "tests/bench/mapped_town.h"
#include "tests/formats/map/random_map.h"

namespace {

using namespace sightline;

struct BenchOptions {
  std::vector<std::string> worlds = {"town-streets"};
  std::vector<std::uint64_t> seeds = {1};
  double length_m = 600.0;
  int beams = 16;
  std::size_t every = 5;
  int threads = 2;
  double least = 0.36;
  std::string map, recording, truth;
  std::string sensor = "generic-16";
  std::string scans;  // file for one line a scan
};

MappedTownOptions town_of(const BenchOptions& options, const std::string& world,
                          std::uint64_t seed) {
  MappedTownOptions making;
  making.town.seed = seed;
  making.town.length_m = options.length_m;
  making.town.world = town::world_kind(world).value_or(town::WorldKind());
  making.beams = options.beams;
  making.threads = options.threads;
  return making;
}

// Whole, since the NDs are needed here too.
Result<VehicleLocalizer> open_whole(const std::string& path) {
  sightline_localizer_options options{};
  options.holds_whole_map = 1;
  return VehicleLocalizer::open(path, options);
}

// The vehicle's library opens files only.
Result<VehicleLocalizer> open(const MappedTown& town) {
  CompiledMap map = random_map({.site_count = 10, .run_count = 1, .looks = {}});
  map.ndt = town.map;
  map.sites.frame = map.ndt.frame;
  map.measurement.localizer.name = "searching";
  map.sensor = town.sensor;
  const std::filesystem::path path = std::filesystem::temp_directory_path() / "place_bench.slmap";
  SIGHTLINE_TRY(write_file_atomically(path, encode_map(map), IfExists::kReplace));
  Result<VehicleLocalizer> localizer = open_whole(path.string());
  std::filesystem::remove(path);
  return localizer;
}

struct Tried {
  bool is_found = false;
  double met_share = 0.0;
  double likelihood = 0.0;
  double elsewhere = 0.0;  // of likelihood
  Pose T_world_vehicle = Pose::Identity();
  double time_s = 0.0;
};

// A map that is searched.
class Searched {
 public:
  Searched(const BenchOptions& options, const SensorProfile& sensor,
           const VehicleLocalizer& localizer, const std::vector<Eigen::Vector3d>& route_world_m)
      : options_(options),
        sensor_(sensor),
        localizer_(localizer),
        check_(localizer.info()),
        finder_(check_.map(), route_world_m, sensor.T_vehicle_lidar) {}

  [[nodiscard]] Tried find(const Scan& scan) const {
    const auto begin = std::chrono::steady_clock::now();
    MapLook look;
    look.range_m = 50.0;
    const auto found = find_place({localizer_, check_, finder_, look}, scan,
                                  upright_of(scan, sensor_), options_.threads);
    Tried tried;
    tried.time_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    if (!found || !*found) return tried;
    tried.met_share = (*found)->met_share;
    tried.likelihood = (*found)->likelihood;
    tried.elsewhere = (*found)->likelihood_elsewhere / (*found)->likelihood;
    tried.is_found = tried.met_share >= options_.least && is_sure(**found);
    tried.T_world_vehicle = pose_of((*found)->match.T_world_vehicle);
    return tried;
  }

 private:
  const BenchOptions& options_;
  const SensorProfile& sensor_;
  const VehicleLocalizer& localizer_;
  PlaceCheck check_;
  PlaceFinder finder_;
};

std::vector<Eigen::Vector3d> route_of(const MappedTown& mapped) {
  std::vector<Eigen::Vector3d> route_world_m;
  for (const Pose& pose : mapped.T_map_vehicle) {
    route_world_m.emplace_back(rebase(pose, mapped.map.frame, MapFrame{}) *
                               mapped.sensor.T_vehicle_lidar.translation());
  }
  return route_world_m;
}

// What was found of the scans of a map's own places, and of others.
struct Row {
  std::string name;
  std::FILE* lines = nullptr;
  int right = 0, refused = 0, wrong = 0, foreign = 0, foreign_all = 0;
  std::vector<double> times_s = {}, met = {}, elsewhere = {}, wrongs = {};
};

bool is_right(const Pose& found, const Pose& truth) {
  const Pose off = truth.inverse(Eigen::Isometry) * found;
  return off.translation().norm() < 0.5 && rotation_angle_rad(off.linear()) < 0.0873;
}

double at(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::ranges::sort(values);
  return values[std::min(values.size() - 1,
                         static_cast<std::size_t>(share * static_cast<double>(values.size())))];
}

void print_line(const Row& row, std::size_t scan, const char* what, const Tried& tried) {
  if (row.lines == nullptr) return;
  std::fprintf(row.lines, "%s %zu %s %d %.3f %.3f %.3f\n", row.name.c_str(), scan, what,
               tried.is_found ? 1 : 0, tried.met_share, tried.elsewhere, tried.likelihood);
}

void count_own(std::size_t scan, const Tried& tried, const Pose& T_world_true, Row& row) {
  const bool good = is_right(tried.T_world_vehicle, T_world_true);
  row.times_s.push_back(tried.time_s);
  (!tried.is_found ? row.refused : good ? row.right : row.wrong) += 1;
  if (good) row.met.push_back(tried.met_share);
  (good ? row.elsewhere : row.wrongs).push_back(tried.elsewhere);
  print_line(row, scan, good ? "right" : "wrong", tried);
}

void count_foreign(std::size_t scan, const Tried& tried, Row& row) {
  row.foreign += tried.is_found ? 1 : 0;
  ++row.foreign_all;
  print_line(row, scan, "foreign", tried);
}

void print(const Row& row) {
  std::printf("%-22s %6zu %6d %7d %6d %4d/%-4d %10.2f %5.2f %12.2f %12.3f %12.3f\n",
              row.name.c_str(), row.times_s.size(), row.right, row.refused, row.wrong, row.foreign,
              row.foreign_all, at(row.times_s, 0.5), at(row.times_s, 0.95), at(row.met, 0.05),
              at(row.elsewhere, 0.95), at(row.wrongs, 0.0));
  std::fflush(stdout);
}

Result<void> run_world(const BenchOptions& options, const std::string& world, std::uint64_t seed,
                       std::FILE* lines) {
  const MappedTown mapped = make_mapped_town(town_of(options, world, seed));
  const MappedTown other = make_mapped_town(town_of(options, world, seed + 500));
  SIGHTLINE_ASSIGN(const VehicleLocalizer localizer, open(mapped));
  const Searched searched(options, mapped.sensor, localizer, route_of(mapped));
  Row row{world + " " + std::to_string(seed), lines};
  for (std::size_t i = 0; i < mapped.scans.size(); i += options.every) {
    count_own(i, searched.find(mapped.scans[i]),
              rebase(mapped.T_map_vehicle[i], mapped.map.frame, MapFrame{}), row);
  }
  for (std::size_t i = 0; i < other.scans.size(); i += 2 * options.every) {
    count_foreign(i, searched.find(other.scans[i]), row);
  }
  print(row);
  return {};
}

// Without poses of the recording its scans are foreign.
Result<void> run_recording(const BenchOptions& options, std::FILE* lines) {
  RecordingOptions drive;
  drive.scans = options.recording;
  drive.sensor = options.sensor;
  SIGHTLINE_ASSIGN(const Recording recording, list_recording(drive));
  SIGHTLINE_ASSIGN(const VehicleLocalizer localizer, open_whole(options.map));
  SIGHTLINE_ASSIGN(const MapReader map, MapReader::open(options.map, "searching"));
  SIGHTLINE_ASSIGN(const std::vector<MapSite> sites, map.sites(0));
  std::vector<Eigen::Vector3d> route_world_m;
  for (const MapSite& site : sites) {
    route_world_m.emplace_back(Eigen::Map<const Eigen::Vector3d>(site.position_world_m.data()));
  }
  SensorProfile sensor = recording.sensor;
  sensor.T_vehicle_lidar = pose_of(localizer.info().T_vehicle_sensor);
  const Searched searched(options, sensor, localizer, route_world_m);
  std::vector<PoseRow> truth;
  if (!options.truth.empty()) {
    SIGHTLINE_ASSIGN(truth, read_poses(options.truth, PoseFormat::kAuto));
  }
  Row row{options.recording, lines};
  const std::shared_ptr<const ScanStore> store = listed_scan_store(recording);
  for (std::size_t i = 0; i < recording.scans.size(); i += options.every) {
    SIGHTLINE_ASSIGN(const Scan scan, store->read(i));
    if (truth.empty()) {
      count_foreign(i, searched.find(scan), row);
    } else if (i < truth.size()) {
      count_own(i, searched.find(scan), truth[i].T_world_vehicle, row);
    }
  }
  print(row);
  return {};
}

Result<void> run(const BenchOptions& options) {
  std::FILE* const lines = options.scans.empty() ? nullptr : std::fopen(options.scans.c_str(), "w");
  std::printf(
      "map                     scans  right refused  wrong  foreign   seconds p50  p95   met right "
      "p5  ratio elsewhere right p95, wrong least\n");
  if (!options.map.empty()) {
    SIGHTLINE_TRY(run_recording(options, lines));
  } else {
    for (const std::string& world : options.worlds) {
      for (const std::uint64_t seed : options.seeds) {
        SIGHTLINE_TRY(run_world(options, world, seed, lines));
      }
    }
  }
  if (lines != nullptr) std::fclose(lines);
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  BenchOptions options;
  CLI::App app("Global localization in maps of generated worlds");
  app.add_option("--worlds", options.worlds, "tunnel, motorway, mixed, ...; town-streets");
  app.add_option("--seeds", options.seeds);
  app.add_option("--length-m", options.length_m);
  app.add_option("--beams", options.beams);
  app.add_option("--every", options.every, "one in so many scans");
  app.add_option("--threads", options.threads);
  app.add_option("--least", options.least, "share of upright points that must meet the map");
  app.add_option("--map", options.map, "of a recording (.slmap), in place of generated worlds");
  app.add_option("--recording", options.recording, "scans to find in --map");
  app.add_option("--sensor", options.sensor, "of the recording");
  app.add_option("--truth", options.truth,
                 "poses of its scans, in their order (TUM); none: foreign");
  app.add_option("--scans", options.scans, "file for one line a scan");
  CLI11_PARSE(app, argc, argv);
  if (const Result<void> done = run(options); !done) {
    std::printf("%s\n", to_string(done.error()).c_str());
    return 1;
  }
  return 0;
}
