#include <cstdio>

#include "compiler/config/config_file.h"
#include "compiler/pipeline/runner.h"
#include "examples/your_own_pass/clearance.h"
#include "formats/map/map_reader.h"

// Runs a pass of one's own over a finished map and prints what it made, as CSV.

namespace sightline {
namespace {

// Step 3, the plan: one line connects the pass to what it takes.
struct ClearancePlan {
  Plan plan;
  Wire<NdtMap> ndt;
  Wire<Sites> sites;
  Wire<SiteColumn> clearance;
};

ClearancePlan clearance_plan(const PassSettings& settings) {
  ClearancePlan planned{Plan(settings), {}, {}, {}};
  planned.ndt = planned.plan.input<NdtMap>("nds");
  planned.sites = planned.plan.input<Sites>("sites");
  planned.clearance = planned.plan.run(kMeasureClearance, planned.ndt, planned.sites);
  return planned;
}

// The settings in a YAML file; the plan itself says which sections and keys there are.
Result<PassSettings> read_settings(const char* file) {
  std::vector<ConfigSection> sections = sections_of(clearance_plan({}).plan);
  SIGHTLINE_TRY(read_yaml(file, sections));
  return settings_of(sections);
}

Result<Table> run(const char* map_file, const char* config_file) {
  Result<PassSettings> settings = PassSettings{};
  if (config_file != nullptr) settings = read_settings(config_file);
  if (!settings) return settings.error();
  SIGHTLINE_ASSIGN(const CompiledMap map, read_map(map_file));
  const ClearancePlan planned = clearance_plan(*settings);
  ArtifactSet artifacts;
  artifacts.provide(planned.ndt, map.ndt);
  artifacts.provide(planned.sites, map.sites);
  std::vector<StepReport> reports;
  SIGHTLINE_TRY(run_plan(planned.plan, {}, {}, {}, artifacts, reports));
  return dump(artifacts.get(planned.clearance));
}

}  // namespace
}  // namespace sightline

int main(int argc, char** argv) {
  using namespace sightline;
  if (argc != 2 && argc != 3) {
    std::fprintf(stderr, "usage: %s MAP.slmap [CONFIG.yaml]\n", argv[0]);
    return exit_status(ErrorCode::kBadArgument);
  }
  const Result<Table> table = run(argv[1], argc == 3 ? argv[2] : nullptr);
  if (!table) {
    std::fprintf(stderr, "%s\n", to_string(table.error()).c_str());
    return exit_status(table.error().code);
  }
  std::fputs(format_table(*table, TableFormat::kCsv).c_str(), stdout);
  return 0;
}
