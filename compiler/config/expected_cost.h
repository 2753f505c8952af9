#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "compiler/config/compile_config.h"
#include "compiler/pipeline/runner.h"

// What a run will cost, as far as its recordings tell without being read. Figures are those of
// --time-passes on towns of 16 beams and KITTI's 64: good to a factor of two or three.

namespace sightline {

struct ExpectedStep {
  std::string name;
  bool is_in_cache = false;
  double wall_s = 0.0;
  double counted = 1.0;  // the share of it that its progress counts
};

struct ExpectedDrive {
  std::string role;  // "mapping", "localization", ...
  std::size_t scan_count = 0;
  double points_per_scan = 0.0;
};

// Of a finished map: what its places take from here to the map.
struct ExpectedPlaces {
  std::size_t count = 0;
  std::size_t tried_count = 0;  // of them
  double cpu_s = 0.0;           // one core
};

struct ExpectedCost {
  std::vector<ExpectedDrive> drives;
  std::vector<ExpectedStep> steps;  // in running order
  int threads = 1;
  double memory_mib = 0.0;
  double cache_mib = 0.0;                               // that the run would add to it
  std::optional<ExpectedPlaces> places = std::nullopt;  // where they are known and were tried
};

// Of the steps that run_plan() would take. The recordings of the plan must be in `artifacts`.
ExpectedCost expected_cost(const Plan& plan, const std::vector<AnyWire>& wanted,
                           const RunOptions& options, const CompileConfig& config,
                           const ArtifactSet& artifacts);

// For people, beside what this machine has: memory that is free, and room in the folder of the
// cache (empty: none is kept). Without a drive, in a finished map, what its places take, or one of
// them.
std::string to_text(const ExpectedCost& cost, const std::filesystem::path& cache_directory);

// As schemas/cost.schema.json describes it.
std::string to_json(const ExpectedCost& cost);

}  // namespace sightline
