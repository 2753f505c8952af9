#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace sightline {

// What runs a plan: engines that a cluster has anyway.
struct EngineJob {
  std::filesystem::path program;  // this one, absolute
  std::filesystem::path plan;     // absolute
  std::filesystem::path map;      // to link, absolute
  // Of plan.json, hexadecimal: what was done for another plan does not count.
  std::string plan_digest;
  int shares = 1;  // of each stage that can be shared
};

std::vector<std::string> engine_names();  // "slurm", "make", "snakemake"

// A script that does all stages and links, for an engine of engine_names().
std::string engine_script(std::string_view engine, const EngineJob& job);

}  // namespace sightline
