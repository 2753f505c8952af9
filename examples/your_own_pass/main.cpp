#include <cstdio>

#include "compiler/pipeline/runner.h"
#include "examples/your_own_pass/clearance.h"
#include "formats/map/map_reader.h"

// Runs a pass of one's own over a finished map and prints what it made, as CSV.
int main(int argc, char** argv) {
  using namespace sightline;
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s MAP.slmap\n", argv[0]);
    return exit_status(ErrorCode::kBadArgument);
  }
  Result<CompiledMap> map = read_map(argv[1]);
  if (!map) {
    std::fprintf(stderr, "%s\n", to_string(map.error()).c_str());
    return exit_status(map.error().code);
  }
  ArtifactSet artifacts;
  artifacts.provide("ndt-map", map->ndt, sha256("ndt"));
  artifacts.provide("sites", map->sites, sha256("sites"));

  // Step 4: one line in the list of passes. Types and the cache key are read off the signature.
  const std::vector<PassStep> steps = {make_step("measure-clearance", kMeasureClearanceVersion,
                                                 &measure_clearance, MeasureClearanceOptions{},
                                                 {"ndt-map", "sites"}, "clearance-table")};

  std::vector<StepReport> reports;
  const Result<void> run = run_pipeline(steps, RunOptions{}, RunObserver{}, artifacts, reports);
  if (!run) {
    std::fprintf(stderr, "%s\n", to_string(run.error()).c_str());
    return exit_status(run.error().code);
  }
  const Table table = dump(artifacts.get<ClearanceTable>("clearance-table"));
  std::fputs(format_table(table, TableFormat::kCsv).c_str(), stdout);
  return 0;
}
