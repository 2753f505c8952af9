#include "compiler/driver/configuration.h"

#include <algorithm>
#include <utility>

#include "compiler/config/inputs.h"
#include "compiler/driver/evaluate_plan.h"
#include "compiler/driver/pipelines.h"

// The configuration, with the options of every pass that a plan runs.

namespace sightline {

std::vector<ConfigSection> published_sections(CompileConfig& config) {
  // With every pass that a compile or an evaluation may run.
  CompileConfig complete;
  complete.localization.scans = "any";
  complete.passes.own["emit-map"]["size"] = "promise";
  CompileConfig finished = complete;
  finished.map.points = "any";
  CompileConfig everywhere = finished;
  everywhere.route.file = RouteOptions::kEverywhere;
  CompileConfig of_nds = finished;
  of_nds.map.is_apollo = true;
  complete.other_sensors.front().scans = "any";
  complete.base_poses = "any";
  complete.later_mapping.resize(1);
  complete.later_mapping.front().scans = "any";
  std::vector<ConfigSection> sections = drive_sections(config);
  for (const Plan& plan :
       {compile_plan(complete).plan, compile_plan(finished).plan, compile_plan(everywhere).plan,
        compile_plan(of_nds).plan, evaluate_plan(complete, CompiledMap{}).plan}) {
    for (ConfigSection& pass : sections_of(plan)) {
      if (std::ranges::find(sections, pass.name, &ConfigSection::name) != sections.end()) continue;
      sections.push_back(std::move(pass));
    }
  }
  sections.push_back(gate_section());
  return sections;
}

Result<CompileConfig> load_compile_config(const std::filesystem::path& file,
                                          const std::vector<std::string>& overrides) {
  CompileConfig config;
  SIGHTLINE_TRY(read_compile_config(file, overrides, published_sections(config), config));
  const Result<void> settled = settle_same_recordings(config);
  if (!settled) return in_file(settled.error(), file.string());
  return config;
}

Result<CompileConfig> compile_config_of(const std::vector<std::string>& overrides) {
  return load_compile_config({}, overrides);
}

}  // namespace sightline
