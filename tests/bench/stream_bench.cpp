// A vehicle drives a long map through the C interface at 30 m/s, 10 scans a second: time to open,
// of the first match and of each match, memory, allocations, and a digest of all matches, which
// must be the same in every mode.
//
//   link_memory TOWN.slmap 30 LONG.slmap
//   stream_bench TOWN.slmap LONG.slmap TOWN/drive_1 --metres 20000 --mode thread
//
// The drive goes through a town that stands in the long map again and again; between two towns
// there is nothing to match in.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <new>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "formats/base/hash.h"
#include "formats/base/stopwatch.h"
#include "formats/foreign/clouds/read_point_cloud.h"
#include "formats/foreign/recording/scan_files.h"
#include "formats/geometry.h"
#include "formats/map/map_reader.h"
#include "passes/vehicle/sightline_localizer.h"

namespace {
thread_local std::size_t g_allocation_count = 0;

void* counted(std::size_t size, std::size_t alignment) {
  ++g_allocation_count;
  void* const memory =
      alignment <= 16
          ? std::malloc(size)
          : std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
}  // namespace

void* operator new(std::size_t size) { return counted(size, 16); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return counted(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

namespace {

using namespace sightline;

struct Options {
  std::string town, map, drive;
  std::string mode = "thread";  // thread, steps, none, whole
  double metres = 6000.0;
  double period_ms = 100.0;
  double budget_ms = 2.0;
  double range_m = 0.0;  // every return within; 0: a sample by normals
};

struct DrivenScan {
  std::vector<float> xyz;
  Eigen::Vector3d place_m;
  Eigen::Matrix3d turn;
};

double wall_ms() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double, std::milli>(now).count();
}

// Of /proc/self/status.
double status_mib(const std::string& name) {
  std::ifstream file("/proc/self/status");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with(name + ":")) return std::stod(line.substr(name.size() + 1)) / 1024.0;
  }
  return 0.0;
}

std::vector<DrivenScan> drive_of(const std::string& folder, std::size_t stride) {
  std::ifstream poses(folder + "/poses.tum");
  const std::vector<std::filesystem::path> files = *list_scan_files(folder + "/scans");
  std::vector<DrivenScan> scans;
  std::size_t number = 0;
  for (std::string line; std::getline(poses, line);) {
    if (line.empty() || line[0] == '#') continue;
    if (number++ % stride != 0) continue;
    std::istringstream numbers(line);
    double stamp_s, x, y, z, qx, qy, qz, qw;
    numbers >> stamp_s >> x >> y >> z >> qx >> qy >> qz >> qw;
    DrivenScan& scan = scans.emplace_back();
    scan.place_m = {x, y, z};
    scan.turn = Eigen::Quaterniond(qw, qx, qy, qz).normalized().toRotationMatrix();
    const Result<PointCloudFile> cloud = read_point_cloud(files[number - 1]);
    if (!cloud) std::exit(EXIT_FAILURE);
    for (const Eigen::Vector3d& point_m : cloud->points_m) {
      for (int i = 0; i < 3; ++i) scan.xyz.push_back(static_cast<float>(point_m[i]));
    }
  }
  return scans;
}

// As link_memory lays its copies.
double step_of_copies_m(const std::string& town) {
  const Result<CompiledMap> map = read_map(town);
  if (!map) std::exit(EXIT_FAILURE);
  const NdtMap& ndt = map->ndt;
  const auto [west, east] =
      std::ranges::minmax_element(ndt.nds, {}, [](const Nd& nd) { return nd.key.x; });
  const auto cells_of_tile = static_cast<std::int32_t>(ndt.tile_m / ndt.cell_m);
  const std::int32_t tiles = (east->key.x - west->key.x) / cells_of_tile + 2;
  return tiles * cells_of_tile * ndt.cell_m;
}

struct Figures {
  std::vector<double> wall_ms, cpu_ms;
  std::size_t allocations = 0, allocating_matches = 0, lost = 0;
  DigestBuilder digest;
  double most_anonymous_mib = 0.0, most_resident_mib = 0.0;
  double prepare_most_ms = 0.0, prepare_most_cpu_ms = 0.0;
};

class Driver {
 public:
  Driver(const Options& options, sightline_localizer* localizer, Figures& figures)
      : options_(options), localizer_(localizer), figures_(figures) {
    if (options.range_m > 0.0) {
      look_.range_m = options.range_m;
    } else {
      look_.range_m = 50.0;
      look_.return_count = 2000;
      look_.point_count = 80;
      look_.is_by_normals = 1;
    }
    next_ms_ = wall_ms();
  }

  // A match from a start that is 0.25 m and half a degree off.
  void match(const DrivenScan& scan, const Eigen::Vector3d& place_m, bool is_mapped) {
    const Eigen::Matrix3d turn =
        scan.turn * Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    Eigen::Matrix<double, 3, 4, Eigen::RowMajor> start;
    start << turn, place_m + Eigen::Vector3d(0.2, 0.15, 0.0);
    const sightline_points points = {scan.xyz.data(), scan.xyz.size() / 3, 12, 0};
    sightline_match found;
    const std::size_t allocations = g_allocation_count;
    const double cpu_ms = thread_cpu_ms();
    const double begin_ms = wall_ms();
    if (sightline_localizer_match(localizer_, &points, start.data(), &look_, nullptr, &found) !=
        0) {
      std::exit(EXIT_FAILURE);
    }
    if (is_mapped) {
      figures_.wall_ms.push_back(wall_ms() - begin_ms);
      figures_.cpu_ms.push_back(thread_cpu_ms() - cpu_ms);
      if (figures_.wall_ms.size() > 200) {
        figures_.allocations += g_allocation_count - allocations;
        figures_.allocating_matches += g_allocation_count == allocations ? 0 : 1;
      }
      const Eigen::Vector3d pose_m(found.T_world_vehicle[3], found.T_world_vehicle[7],
                                   found.T_world_vehicle[11]);
      figures_.lost += (pose_m - place_m).norm() < 0.5 ? 0 : 1;
    }
    figures_.digest.add(std::as_bytes(std::span(&found, 1)));
    after_match(place_m);
  }

 private:
  void after_match(const Eigen::Vector3d& place_m) {
    if (options_.mode == "steps") {
      const double begin_ms = wall_ms();
      const double cpu_ms = thread_cpu_ms();
      sightline_localizer_prepare(localizer_, place_m.data(), options_.budget_ms, nullptr);
      figures_.prepare_most_ms = std::max(figures_.prepare_most_ms, wall_ms() - begin_ms);
      figures_.prepare_most_cpu_ms =
          std::max(figures_.prepare_most_cpu_ms, thread_cpu_ms() - cpu_ms);
    }
    if (++count_ % 10 == 0) {
      figures_.most_anonymous_mib = std::max(figures_.most_anonymous_mib, status_mib("RssAnon"));
      figures_.most_resident_mib = std::max(figures_.most_resident_mib, status_mib("VmRSS"));
    }
    next_ms_ += options_.period_ms;
    const double left_ms = next_ms_ - wall_ms();
    if (left_ms > 0.0)
      std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(left_ms));
  }

  const Options& options_;
  sightline_localizer* localizer_;
  Figures& figures_;
  sightline_look look_{};
  double next_ms_ = 0.0;
  int count_ = 0;
};

double drive_all(const Options& options, const std::vector<DrivenScan>& scans, double step_m,
                 Driver& driver) {
  constexpr double kScanStep_m = 3.0;
  double driven_m = 0.0;
  for (int copy = 0; driven_m < options.metres; ++copy) {
    const Eigen::Vector3d shift_m(copy * step_m, 0.0, 0.0);
    for (const DrivenScan& scan : scans) {
      driver.match(scan, scan.place_m + shift_m, true);
      driven_m += kScanStep_m;
      if (driven_m >= options.metres) return driven_m;
    }
    const Eigen::Vector3d from_m = scans.back().place_m + shift_m;
    const Eigen::Vector3d way_m =
        scans.front().place_m + shift_m + Eigen::Vector3d(step_m, 0.0, 0.0) - from_m;
    const int gap_count = static_cast<int>(way_m.norm() / kScanStep_m);
    for (int i = 1; i < gap_count; ++i) {
      driver.match(scans.back(), from_m + way_m * i / gap_count, false);
    }
  }
  return driven_m;
}

double quantile(std::vector<double> values, double share) {
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

void print(const char* name, const std::vector<double>& all_ms) {
  const std::vector<double> later(all_ms.begin() + 1, all_ms.end());
  const double median_ms = quantile(later, 0.5);
  std::printf(
      "%s: first %.2f ms; then median %.3f, p99 %.3f, p99.9 %.3f, slowest %.3f ms, over the "
      "median by %.3f\n",
      name, all_ms.front(), median_ms, quantile(later, 0.99), quantile(later, 0.999),
      quantile(later, 1.0), quantile(later, 1.0) - median_ms);
}

int run(const Options& options) {
  const std::vector<DrivenScan> scans = drive_of(options.drive, 3);
  const double step_m = step_of_copies_m(options.town);
  sightline_localizer_options how{};
  how.holds_whole_map = options.mode == "whole" ? 1 : 0;
  how.has_no_thread = options.mode == "thread" ? 0 : 1;
  Figures figures;
  figures.wall_ms.reserve(100000);
  figures.cpu_ms.reserve(100000);
  const double before_anonymous_mib = status_mib("RssAnon");
  const double before_resident_mib = status_mib("VmRSS");
  sightline_localizer* localizer = nullptr;
  char message[500];
  const double cpu_ms = thread_cpu_ms();
  const double begin_ms = wall_ms();
  if (sightline_localizer_open(options.map.c_str(), &how, &localizer, message, sizeof message) !=
      0) {
    std::fprintf(stderr, "%s\n", message);
    return EXIT_FAILURE;
  }
  std::printf("open: %.2f ms, %.2f ms of CPU\n", wall_ms() - begin_ms, thread_cpu_ms() - cpu_ms);
  Driver driver(options, localizer, figures);
  const double driven_m = drive_all(options, scans, step_m, driver);
  std::printf("%s: %.1f km driven, %zu matches, %zu farther than 0.5 m off, faults %zu\n",
              options.mode.c_str(), driven_m / 1000.0, figures.wall_ms.size(), figures.lost,
              sightline_localizer_fault_count(localizer));
  print("a match, wall", figures.wall_ms);
  print("a match, CPU", figures.cpu_ms);
  std::printf("allocations behind 200 matches: %zu in %zu matches\n", figures.allocations,
              figures.allocating_matches);
  std::printf(
      "memory above that before opening: %.1f MiB without pages of the file, %.1f MiB with\n",
      figures.most_anonymous_mib - before_anonymous_mib,
      figures.most_resident_mib - before_resident_mib);
  if (options.mode == "steps")
    std::printf("longest prepare: %.2f ms, %.2f ms of CPU\n", figures.prepare_most_ms,
                figures.prepare_most_cpu_ms);
  std::printf("digest of all matches: %s\n", to_hex(figures.digest.finish()).c_str());
  sightline_localizer_close(localizer);
  return EXIT_SUCCESS;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Drives a long map as a vehicle does, and measures the localizer.");
  app.add_option("town", options.town, "map of a town")->required();
  app.add_option("map", options.map, "the long map that link_memory made of it")->required();
  app.add_option("drive", options.drive, "folder of a drive through the town")->required();
  app.add_option("--mode", options.mode, "thread, steps, none or whole")
      ->check(CLI::IsMember({"thread", "steps", "none", "whole"}));
  app.add_option("--metres", options.metres, "to drive in towns, 3 m between two scans");
  app.add_option("--period-ms", options.period_ms, "between two matches; 0: as fast as it goes");
  app.add_option("--budget-ms", options.budget_ms, "of a prepare behind each match, in mode steps");
  app.add_option("--range-m", options.range_m, "every return within; 0: a sample of 80 by normals");
  CLI11_PARSE(app, argc, argv);
  return run(options);
}
