#include <filesystem>
#include <memory>

#include "compiler/cli/common_flags.h"
#include "compiler/commands/commands.h"
#include "compiler/commands/map/compile_to_map.h"
#include "compiler/driver/configuration.h"

namespace sightline {
namespace {

Result<void> run_compile(const CompileFlags& flags) {
  SIGHTLINE_ASSIGN(const CompileConfig config,
                   load_compile_config(flags.run.config_file, flags.run.overrides));
  return compile_to_map(flags, config);
}

struct AnnotateFlags {
  CompileFlags compile;
  std::string map;
  std::string route;
  std::string sensor;
  std::string world = "local";
};

Result<void> check(const AnnotateFlags& flags) {
  std::error_code ignored;
  const bool is_missing = !std::filesystem::exists(flags.map, ignored);
  if (!flags.sensor.empty() || is_missing || is_compiled_map(flags.map)) return {};
  return Error{ErrorCode::kBadArgument,
               "--sensor is required: which LiDAR will localize (a compiled map names its own)"};
}

std::vector<std::string> overrides_of(const AnnotateFlags& flags) {
  std::vector<std::string> overrides = {"map.points=" + flags.map, "map.sensor=" + flags.sensor,
                                        "route.file=" + flags.route, "route.world=" + flags.world};
  const std::vector<std::string>& named = flags.compile.run.overrides;
  overrides.insert(overrides.end(), named.begin(), named.end());
  return overrides;
}

Result<void> annotate(const AnnotateFlags& flags) {
  SIGHTLINE_TRY(check(flags));
  SIGHTLINE_ASSIGN(const CompileConfig config, compile_config_of(overrides_of(flags)));
  CompileFlags compile = flags.compile;
  // There is no configuration beside which finished artifacts could lie.
  if (compile.run.cache_directory.empty()) {
    compile.run.cache_directory =
        (std::filesystem::path(compile.output).parent_path() / ".sightline-cache").string();
  }
  return compile_to_map(compile, config);
}

}  // namespace

Verb compile_verb() {
  const auto flags = std::make_shared<CompileFlags>();
  Verb verb;
  verb.name = "compile";
  verb.summary = "Compile drives into an annotated map";
  verb.details =
      "Prints which map was written, the verdict on it, its promise, and the next command. "
      "Finished passes are cached: after an interruption or a change only what is affected runs "
      "again.\n\n"
      "Ranges and probabilities are for the localizer whose errors were measured: one of this "
      "program's own, PCL's NDT (measure-error.localizer), or any other whose errors the section "
      "import-errors names, as CSV: a line \"scan,look,start,error\", then one error a line.";
  verb.examples = {
      "sightline compile town.yaml -o town.slmap",
      "sightline compile street.yaml -o street.slmap --model city.slmodel --risk 0.1",
      "sightline compile city.yaml -o city.slmap --strict",
      "sightline compile city.yaml -o city.slmap --resolve --force",
      "sightline compile town.yaml -o town.slmap --set measure-error.localizer=pcl-ndt",
      ("sightline compile town.yaml -o town.slmap --set import-errors.file=my_errors.csv \\\n"
       "      --set import-errors.localizer=my-ndt"),
      "sightline compile town.yaml -o town.slmap --set build-ndt.cell_m=1.0 --explain",
      "sightline compile town.yaml --stop-after build-ndt --print-after build-ndt",
      "sightline compile town.yaml -o town.slmap --force --depfile town.d --json-progress"};
  add_compile_flags(verb, *flags);
  verb.flags.push_back(
      {.names = "--resolve",
       .help = "Estimate the poses of all mapping drives again, also if base.poses names those of "
               "an earlier map",
       .target = Setter([flags](const std::string& /*value*/) -> Result<void> {
         flags->run.overrides.emplace_back("base.poses=");
         return {};
       })});
  verb.flags.push_back({.names = "--poses",
                        .value = "FILE",
                        .help = "Also write where the scans of the mapping drive were (.slposes), "
                                "for base of a map with more drives; of several drives they are "
                                "written beside the map",
                        .target = &flags->poses});
  add_run_flags(verb, flags->run);
  verb.run = [flags] { return exit_status_of(run_compile(*flags)); };
  return verb;
}

Verb annotate_verb() {
  const auto flags = std::make_shared<AnnotateFlags>();
  Verb verb;
  verb.name = "annotate";
  verb.summary = "Annotate a finished map along a route or everywhere, without any drive";
  verb.details =
      "Does the same as `sightline compile` with the sections map and route in the configuration. "
      "NDs and the surface are computed from the points of the map. Scans of the named sensor are "
      "simulated in the map, disturbed and localized there. Places whose answers are from "
      "simulated scans are marked \"simulated\" in the map.\n\n"
      "With --model, an error model of other places predicts the errors. Without one, twice the "
      "simulated error counts: every place has the one look that is enough at 95 % of the places, "
      "and the range that is enough there and 3 m around it, between those that are enough at 80 "
      "and at 95 % of the places. Judge such a map by a drive (`sightline evaluate`) before a "
      "vehicle uses it. Only a model that was trained on finished maps with drives through them "
      "gives a promise.\n\n"
      "Name later drives with --set localization.scans=... to use their measurements.\n\n"
      "--route everywhere annotates every place of a grid of 2 m that a vehicle can reach on the "
      "ground of the map, free of walls and low obstacles. Only the geometry counts, so lawns and "
      "car parks are included (options: section choose-field-sites).\n\n"
      "A compiled map (.slmap) can be annotated again, for another sensor, route or model. Its "
      "NDs, "
      "frame and world do not change. It contains no surface, so rays are cast on its NDs, which "
      "is "
      "less exact; use the points of the map if you have them. In Apollo's NDT map (the folder of "
      "config.xml and map/), cells are used as NDs, in the UTM zone that the map names.";
  verb.examples = {
      "sightline annotate autoware_map/ --route lanelet2_map.osm --sensor vlp-16 -o city.slmap",
      ("sightline annotate city.las --route lanes.geojson --world utm:32N --sensor hdl-64e \\\n"
       "      --model towns.slmodel -o city.slmap"),
      ("sightline annotate map.pcd --route drive.tum --sensor os1-64 -o city.slmap \\\n"
       "      --set map.height_m=2.1"),
      ("sightline annotate map.pcd --route everywhere --sensor vlp-16 -o field.slmap \\\n"
       "      --set choose-field-sites.within=0,-50,200,50"),
      "sightline annotate apollo/ndt_map --route drive.tum --sensor hdl-64e -o place.slmap",
      "sightline annotate city.slmap --route lanes.geojson --sensor os1-64 -o city64.slmap"};
  verb.positionals = {{.name = "MAP",
                       .help = "The finished map: .pcd, .ply or .las, a folder of them, Autoware's "
                               "or Apollo's map folder, or a compiled map (.slmap) to annotate "
                               "again",
                       .target = &flags->map}};
  verb.flags = {{.names = "--route",
                 .value = "FILE",
                 .help = "Where to annotate it: Lanelet2 (.osm), .geojson, .csv of x, y and z, a "
                         "trajectory (.tum), or everywhere",
                 .target = &flags->route,
                 .is_required = true},
                {.names = "--sensor",
                 .value = "NAME",
                 .help = "The LiDAR that will localize; a wrong name lists all. Without: that of "
                         "the earlier map (.slmap)",
                 .target = &flags->sensor},
                world_flag(flags->world)};
  add_compile_flags(verb, flags->compile);
  add_flags_of_every_run(verb, flags->compile.run);
  verb.run = [flags] { return exit_status_of(annotate(*flags)); };
  return verb;
}

}  // namespace sightline
