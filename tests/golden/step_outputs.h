#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "formats/base/hash.h"
#include "formats/base/result.h"
#include "formats/text/table.h"

// What the golden test sees of a pipeline. Which steps there are, in which order, and what they
// take and make comes from the pipeline; step_outputs.cpp alone knows how a pipeline is put
// together.

namespace sightline::golden {

struct StepOutput {
  std::string step;              // "build-ndt", "ingest:localization"
  std::string version_constant;  // "kBuildNdt"; empty: nothing has a version
  std::uint32_t version = 0;
  std::string artifact;             // what it made: "nds"
  std::string encoding;             // type and version of the encoding: "ndt-map 2"
  std::vector<std::string> inputs;  // artifacts that it took
  Digest digest{};                  // of the whole artifact
  Table table;                      // all of its rows
};

struct RunOutput {
  std::string name;  // of the folder with its golden files: "town16"
  std::vector<StepOutput> steps;
};

// Runs without a cache, on so many threads (0: all there are), what a configuration allows:
//   NAME              the compile
//   NAME-evaluate     its map judged by the evaluation drive, where one is named
//   NAME-given-model  the compile with the error model given, not learnt
// The first step of each is "inputs", digests of what is taken from outside; the last of a compile
// "map-file", the map's own bytes. A later run leaves out what an earlier one gave just so.
// Errors: those of the configuration, the recordings and the passes.
Result<std::vector<RunOutput>> run_town(const std::string& name,
                                        const std::filesystem::path& config_file, int threads);

}  // namespace sightline::golden
