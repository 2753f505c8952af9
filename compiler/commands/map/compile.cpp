#include <memory>

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

Setter resolve_setter(CompileFlags& flags) {
  return [&flags](const std::string& /*value*/) -> Result<void> {
    flags.run.overrides.emplace_back("base.poses=");
    return {};
  };
}

}  // namespace

Verb compile_verb() {
  const auto flags = std::make_shared<CompileFlags>();
  Verb verb;
  verb.name = "compile";
  verb.summary = "Compile drives into an annotated map";
  verb.details =
      "The tables on stdout are judged on the localization drive by models that never saw the "
      "place. Finished passes are cached: after an interruption or a change only what is affected "
      "runs again.\n\n"
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
       .help = "Find the poses of all mapping drives anew, also where base names those of an "
               "earlier map (base.poses)",
       .target = resolve_setter(*flags)});
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

}  // namespace sightline
