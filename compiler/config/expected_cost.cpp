#include "compiler/config/expected_cost.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "compiler/pipeline/schedule.h"
#include "formats/base/machine.h"
#include "formats/base/parallel.h"
#include "formats/drive/scan_stores.h"
#include "formats/foreign/recording/recording.h"
#include "formats/text/json_text.h"
#include "formats/text/numbers.h"
#include "formats/text/table.h"
#include "passes/map/places/field_limits.h"

namespace sightline {
namespace {

// What threads wait for each other.
constexpr double kUseOfThreads = 0.85;

// Of a finished map, for each place: one core, and memory.
constexpr const char* kOfPlaces =
    "time    about 0.07 s of one core per place, with one place per metre of route\nmemory  about "
    "200 MiB and 6.5 KiB per place\n        Choose the places first (--stop-after "
    "choose-field-sites or choose-route-sites) for a better estimate:\n        --dry-run then "
    "measures some of them\n";

// Measured on streets of 0.4 to 20 km and on one of 64 beams (tests/bench/README.md, "A long
// street"): what one process takes.
constexpr double kLeast_mib = 130.0;  // program, libraries, and the stretch that is worked on
constexpr double kThread_mib = 7.0;
constexpr double kScan_mib = 0.05;  // of the mapping drive: poses that are refined together
constexpr double kCacheOfScan_mib = 0.13;

struct Size {
  double scans = 0.0;
  double million_points = 0.0;
  bool has_poses = true;
};

// Of the scans that stay in memory, of all drives.
double kept_scans_mib(const std::map<std::string, Size>& sizes) {
  Size all;
  for (const auto& [role, size] : sizes) {
    all.scans += size.scans;
    all.million_points += size.million_points;
  }
  constexpr double kMost = static_cast<double>(ScanMemory::kMost_scans);
  const double share = all.scans > kMost ? kMost / all.scans : 1.0;
  const double bytes = 12e6 * all.million_points * share;
  return std::min(bytes, static_cast<double>(ScanMemory::kMost_bytes)) / (1 << 20);
}

// Bytes of a point in a binary file, on average over the forms that are common.
constexpr double kBytesOfPoint = 18.0;

double bytes_of(const Recording& recording) {
  std::set<std::filesystem::path> files;
  for (const RecordedScan& scan : recording.scans) files.insert(recording.file_of(scan));
  double bytes = 0.0;
  for (const std::filesystem::path& file : files) {
    std::error_code failure;
    const std::uintmax_t size = std::filesystem::file_size(file, failure);
    if (!failure) bytes += static_cast<double>(size);
  }
  return bytes;
}

Size size_of(const Recording& recording) {
  const bool has_poses = std::ranges::any_of(
      recording.scans, [](const RecordedScan& scan) { return scan.T_world_vehicle.has_value(); });
  return {static_cast<double>(recording.scans.size()), bytes_of(recording) / kBytesOfPoint / 1e6,
          has_poses};
}

// By the name of the plan's input, without "/recording".
std::map<std::string, Size> sizes_of(const Plan& plan, const ArtifactSet& artifacts) {
  std::map<std::string, Size> sizes;
  const std::string suffix = "/recording";
  std::set<std::size_t> inputs;
  for (const PassStep& step : plan.steps()) inputs.insert(step.inputs.begin(), step.inputs.end());
  for (const std::size_t input : inputs) {
    const PlannedArtifact& artifact = plan.artifact({input});
    if (!artifact.name.ends_with(suffix) || !artifacts.has({input})) continue;
    const auto& recording = *static_cast<const Recording*>(artifacts.entry({input}).value.get());
    sizes[artifact.name.substr(0, artifact.name.size() - suffix.size())] = size_of(recording);
  }
  return sizes;
}

// "measure-error:own" works on the mapping drive, "ingest:localization" on that one.
const Size& size_for(const std::string& step, const std::map<std::string, Size>& sizes,
                     const Size& mapping) {
  const std::size_t colon = step.find(':');
  const auto found = colon == std::string::npos ? sizes.end() : sizes.find(step.substr(colon + 1));
  return found == sizes.end() ? mapping : found->second;
}

// The share of a step's time that its progress counts, of those that do much more afterwards.
double counted(std::string_view step, const Size& size) {
  if (step.starts_with("estimate-trajectory")) return size.has_poses ? 1.0 : 0.18;
  return 1.0;
}

double cpu_s(const Cost& cost, const Size& size) {
  const double unposed_s = size.has_poses ? 0.0 : cost.without_poses_s;
  return cost.scan_s * size.scans + (cost.million_points_s + unposed_s) * size.million_points;
}

constexpr double kUnknown = std::numeric_limits<double>::infinity();

double free_disk_mib(std::filesystem::path folder) {
  std::error_code failure;
  while (folder.has_parent_path() && !std::filesystem::exists(folder, failure) &&
         folder != folder.parent_path()) {
    folder = folder.parent_path();
  }
  const std::filesystem::space_info space =
      std::filesystem::space(folder.empty() ? "." : folder, failure);
  if (failure) return kUnknown;
  return static_cast<double>(space.available) / 1048576.0;
}

// Two digits: the estimate is no better.
std::string about(double value) {
  if (!(value >= 1.0)) return "1";
  const double unit = std::pow(10.0, std::max(0.0, std::floor(std::log10(value)) - 1.0));
  return fixed(std::round(value / unit) * unit, 0);
}

std::string mib_text(double mib) {
  return mib < 1024.0 ? about(mib) + " MiB" : fixed(mib / 1024.0, 1) + " GiB";
}

std::string time_text(double seconds) {
  if (seconds < 90.0) return about(seconds) + " s";
  if (seconds < 5400.0) return about(seconds / 60.0) + " min";
  return fixed(seconds / 3600.0, 1) + " h";
}

// "  memory  about 560 MiB; 12.0 GiB free"
std::string room_line(const char* what, double needed_mib, double free_mib) {
  std::string line = concat(what, "about ", mib_text(needed_mib));
  if (!std::isfinite(free_mib)) return line + "\n";
  line += concat("; ", mib_text(free_mib), " free");
  return line + (needed_mib > free_mib ? ": not enough\n" : "\n");
}

std::string text_of(const ExpectedPlaces& places) {
  return concat("time    about ", time_text(places.cpu_s), " of one core for ", places.count,
                " places, measured at ", places.tried_count, " of them\n",
                room_line("memory  ", memory_of_places_mib(static_cast<double>(places.count)),
                          free_memory_mib().value_or(kUnknown)));
}

}  // namespace

ExpectedCost expected_cost(const Plan& plan, const std::vector<AnyWire>& wanted,
                           const RunOptions& options, const CompileConfig& config,
                           const ArtifactSet& artifacts) {
  ExpectedCost cost;
  cost.threads = threads_each(options.threads, 1);
  const std::map<std::string, Size> sizes = sizes_of(plan, artifacts);
  Size mapping;
  for (const auto& [role, size] : sizes) {
    const double scans = std::max(1.0, size.scans);
    cost.drives.push_back(
        {role, static_cast<std::size_t>(size.scans), 1e6 * size.million_points / scans});
    if (!role.starts_with("mapping") && sizes.size() > 1) continue;
    // Other sensors scan at the same time, other drives at another.
    mapping.scans = role.starts_with("mapping[") ? mapping.scans + size.scans
                                                 : std::max(mapping.scans, size.scans);
    mapping.million_points += size.million_points;
    mapping.has_poses = mapping.has_poses && size.has_poses;
  }
  // Half of the scans make the map, the other half are localized in it.
  Size used = mapping;
  if (config.is_split() && sizes.contains("mapping")) {
    used.scans *= 0.5;
    used.million_points *= 0.5;
  }
  double total_s = 0.0;
  double missing_s = 0.0;
  for (const PlannedRun& run : planned_runs(plan, wanted, options, artifacts)) {
    const bool is_of_all = run.name.starts_with("estimate-trajectory");
    const Size& size = size_for(run.name, sizes, is_of_all ? mapping : used);
    const double needed_s = cpu_s(plan.steps()[run.step].cost, size) / cost.threads /
                            (cost.threads > 1 ? kUseOfThreads : 1.0);
    total_s += needed_s;
    missing_s += run.is_in_cache ? 0.0 : needed_s;
    cost.steps.push_back(
        {run.name, run.is_in_cache, run.is_in_cache ? 0.0 : needed_s, counted(run.name, size)});
  }
  cost.memory_mib =
      kLeast_mib + kThread_mib * cost.threads + kScan_mib * mapping.scans + kept_scans_mib(sizes);
  const double missing = total_s > 0.0 ? missing_s / total_s : 0.0;
  if (!options.cache_directory.empty()) cost.cache_mib = missing * kCacheOfScan_mib * mapping.scans;
  return cost;
}

std::string to_text(const ExpectedCost& cost, const std::filesystem::path& cache_directory) {
  std::string text;
  for (const ExpectedDrive& drive : cost.drives) {
    text += concat(drive.role, ": ", drive.scan_count, " scans of about ",
                   about(drive.points_per_scan), " points\n");
  }
  TextGrid grid = {{"pass", "estimated time"}};
  double wall_s = 0.0;
  for (const ExpectedStep& step : cost.steps) {
    wall_s += step.wall_s;
    grid.push_back({step.name, step.is_in_cache     ? "in the cache"
                               : step.wall_s >= 0.5 ? time_text(step.wall_s)
                                                    : "-"});
  }
  text += aligned(grid, FirstColumn::kLeft);
  if (cost.places) return text + text_of(*cost.places);
  if (cost.drives.empty()) return text + kOfPlaces;
  text += concat("time    about ", time_text(wall_s), " on ", cost.threads, " threads, ",
                 time_text(0.4 * wall_s), " to ", time_text(2.5 * wall_s), "\n");
  text += room_line("memory  ", cost.memory_mib, free_memory_mib().value_or(kUnknown));
  if (cache_directory.empty()) return text + "disk    only the map: the cache is off\n";
  return concat(text, room_line("disk    ", cost.cache_mib, free_disk_mib(cache_directory)),
                "        in ", cache_directory.string(), "\n");
}

std::string to_json(const ExpectedCost& cost) {
  nlohmann::ordered_json json = {{"drives", nlohmann::ordered_json::array()},
                                 {"steps", nlohmann::ordered_json::array()},
                                 {"threads", cost.threads},
                                 {"memory_mib", cost.memory_mib},
                                 {"cache_mib", cost.cache_mib}};
  for (const ExpectedDrive& drive : cost.drives) {
    json["drives"].push_back({{"role", drive.role},
                              {"scans", drive.scan_count},
                              {"points_per_scan", drive.points_per_scan}});
  }
  for (const ExpectedStep& step : cost.steps) {
    json["steps"].push_back(
        {{"pass", step.name}, {"is_in_cache", step.is_in_cache}, {"wall_s", step.wall_s}});
  }
  if (cost.places) {
    json["places"] = {{"count", cost.places->count},
                      {"tried", cost.places->tried_count},
                      {"cpu_s", cost.places->cpu_s}};
  }
  return json_text(json);
}

}  // namespace sightline
