#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "compiler/cli/result_flags.h"
#include "compiler/cli/run_flags.h"
#include "compiler/commands/commands.h"
#include "compiler/driver/configuration.h"
#include "compiler/driver/pipelines.h"
#include "compiler/driver/provide_inputs.h"
#include "compiler/store/cache.h"
#include "compiler/views/picture/dump_picture.h"
#include "compiler/views/text/table_rows.h"
#include "formats/base/files/atomic_file.h"
#include "formats/map/map_reader.h"

namespace sightline {
namespace {

const std::vector<std::string> kForms = {"text", "csv", "json", "png", "svg"};

struct DumpFlags {
  RunFlags run;  // config_file is the target: a configuration, a map, a model or an artifact
  std::string what;
  ResultFlags result;
  int site = -1;
  std::string box;  // empty: everything

  [[nodiscard]] std::string format() const { return result.chosen_format(kForms); }
};

// The plans of a compile from one drive, from several and from a finished map, in which every pass
// runs.
std::vector<Plan> complete_plans() {
  CompileConfig config;
  config.localization.scans = "any";
  config.passes.own["emit-map"]["size"] = "promise";
  CompileConfig several;
  several.localization.scans = "any";
  several.later_mapping.emplace_back();
  several.base_poses = "any";
  CompileConfig finished;
  finished.localization.scans = "any";
  finished.map.points = "any";
  return {compile_plan(config).plan, compile_plan(several).plan, compile_plan(finished).plan};
}

// Of everything that these plans make.
std::vector<const ArtifactType*> known_types() {
  std::vector<const ArtifactType*> types;
  for (const Plan& plan : complete_plans()) {
    for (const AnyWire wire : plan.made()) types.push_back(plan.artifact(wire).type);
  }
  return types;
}

// Map factors are computed at ranges alone; looks join them with the errors of the map's own scans.
bool has_looks_table(const PlannedArtifact& artifact) {
  const std::string_view kinds[] = {
      ArtifactTraits<FactorTable>::kName, ArtifactTraits<MeasuredError>::kName,
      ArtifactTraits<PredictedError>::kName, ArtifactTraits<RangeTable>::kName};
  return std::ranges::find(kinds, artifact.type->name) != std::end(kinds) &&
         artifact.name != "map-factors";
}

// What --what may name: every artifact of a compile, the recordings it reads, and what maps alone
// have.
std::vector<std::string> dumpable_names() {
  std::vector<std::string> names = {"recordings"};
  for (const Plan& plan : complete_plans()) {
    for (const AnyWire wire : plan.made()) {
      const std::string& name = plan.artifact(wire).name;
      if (std::ranges::find(names, name) != names.end()) continue;
      names.push_back(name);
      if (has_looks_table(plan.artifact(wire))) names.push_back(name + std::string(kLooksSuffix));
    }
  }
  for (const std::string& name : dump_names()) {
    if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  }
  return names;
}

Result<Table> table_of_map(const DumpFlags& flags) {
  SIGHTLINE_ASSIGN(const CompiledMap map, read_map(flags.run.config_file));
  Result<Table> table = dump(map, flags.what);
  if (table) return table;
  Error error = table.error();
  error.file = flags.run.config_file;
  error.message += "; all other tables are dumped from the configuration that compiled it";
  return error;
}

Result<Table> table_of_model(const DumpFlags& flags) {
  SIGHTLINE_ASSIGN(const ByFamily<ErrorModel> model, read_model(flags.run.config_file));
  if (flags.what == "model") return dump(model);
  if (flags.what == "recordings") return recordings_table(model.ranges);
  return Error{ErrorCode::kBadArgument, "--what: a model has the tables model and recordings",
               flags.run.config_file};
}

// The plan of a compile, and the wanted artifacts of it.
struct Made {
  CompilePlan compile;
  ArtifactSet artifacts;
};

// Runs what the artifacts of these names need, from the cache where it can. Errors: unknown-name
// where the configuration makes none of that name; those of check_stop.
Result<Made> make(const DumpFlags& flags, const std::vector<std::string>& names) {
  SIGHTLINE_ASSIGN(const CompileConfig config,
                   load_compile_config(flags.run.config_file, flags.run.overrides));
  Made made{compile_plan(config), {}};
  std::vector<AnyWire> wanted;
  for (const std::string& name : names) {
    wanted.push_back(made.compile.plan.find(name));
    if (wanted.back() != AnyWire{}) continue;
    return Error{ErrorCode::kUnknownName, "--what: this configuration makes no " + name,
                 flags.run.config_file};
  }
  SIGHTLINE_TRY(check_stop(flags.run, made.compile.plan, wanted));
  SIGHTLINE_TRY(provide_drives(made.compile, cache_directory(flags.run), made.artifacts));
  SIGHTLINE_TRY(run_steps(made.compile.plan, wanted, flags.run, config, made.artifacts));
  return made;
}

// Of every recording that the configuration names; reads files and runs no pass.
Result<Table> recordings_of_config(const DumpFlags& flags) {
  SIGHTLINE_ASSIGN(const CompileConfig config,
                   load_compile_config(flags.run.config_file, flags.run.overrides));
  CompilePlan compile = compile_plan(config);
  if (!config.evaluation.scans.empty()) measure_evaluation_drive(config, compile);
  ArtifactSet artifacts;
  SIGHTLINE_TRY(provide_drives(compile, cache_directory(flags.run), artifacts));
  return dump(artifacts.get(compile.cards));
}

Result<Table> table_of_config(const DumpFlags& flags) {
  if (flags.what == "recordings") return recordings_of_config(flags);
  SIGHTLINE_ASSIGN(const Made made, make(flags, {flags.what}));
  const ArtifactSet::Entry& entry = made.artifacts.entry(made.compile.plan.find(flags.what));
  return entry.type->print(entry.value.get());
}

Result<PictureSources> sources_of_config(const DumpFlags& flags) {
  std::vector<std::string> names = {"nds", "sites"};
  if (flags.what == "points") names = {"points"};
  if (flags.what == "depth") names = {"depth", "nds", "sites"};
  if (flags.what == "ranges") names = {"nds", "sites", "ranges"};
  SIGHTLINE_ASSIGN(const Made made, make(flags, names));
  const auto& [compile, artifacts] = made;
  PictureSources sources;
  if (flags.what == "points") {
    sources.points = std::make_shared<const SurfacePoints>(artifacts.get(compile.points));
    return sources;
  }
  if (flags.what == "depth") {
    sources.depth = std::make_shared<const DepthImages>(artifacts.get(compile.depth));
  }
  if (flags.what == "ranges") {
    sources.ranges = std::make_shared<const RangeTable>(artifacts.get(compile.ranges).ranges);
  }
  sources.ndt = std::make_shared<const NdtMap>(artifacts.get(compile.ndt));
  sources.sites = artifacts.get(compile.sites);
  return sources;
}

Result<PictureSources> sources_of_map(const DumpFlags& flags) {
  SIGHTLINE_ASSIGN(CompiledMap map, read_map(flags.run.config_file));
  PictureSources sources;
  sources.ndt = std::make_shared<const NdtMap>(std::move(map.ndt));
  sources.sites = std::move(map.sites);
  sources.ranges = std::make_shared<const RangeTable>(std::move(map.ranges));
  return sources;
}

// An artifact file of the cache names its type.
Result<Table> table_of_artifact(const DumpFlags& flags) {
  SIGHTLINE_ASSIGN(RegularFile file, open_regular_file(flags.run.config_file));
  const std::uint64_t size = file.size;
  const Result<SealedObject> object = open_object({std::move(file.descriptor), size});
  if (!object) return in_file(object.error(), flags.run.config_file);
  for (const ArtifactType* known : known_types()) {
    const ArtifactType& type = *known;
    if (!type.read) continue;
    const Result<std::shared_ptr<const void>> artifact = type.read(object->content);
    if (artifact) return type.print(artifact->get());
    if (artifact.error().code == ErrorCode::kBadLayer) continue;  // another type's
    Error error = artifact.error();
    error.file = flags.run.config_file;
    return error;
  }
  return Error{ErrorCode::kUnsupportedFormat, "no pass of this program makes this type of artifact",
               flags.run.config_file};
}

enum class Target { kConfig, kMap, kModel, kArtifact };

Target target_of(const DumpFlags& flags) {
  const std::filesystem::path extension = std::filesystem::path(flags.run.config_file).extension();
  if (extension == ".sla") return Target::kArtifact;
  if (extension == ".slmodel") return Target::kModel;
  return extension == ".slmap" ? Target::kMap : Target::kConfig;
}

Result<void> dump_picture(const DumpFlags& flags) {
  PictureRequest request;
  request.what = flags.what;
  request.format = flags.format() == "svg" ? PictureFormat::kSvg : PictureFormat::kPng;
  request.site = flags.site;
  if (!flags.box.empty()) {
    SIGHTLINE_ASSIGN(const MapBox box, parse_box(flags.box));
    request.box = box;
  }
  const bool is_drawable = target_of(flags) == Target::kMap || target_of(flags) == Target::kConfig;
  const std::vector<std::string> drawable = {"depth", "nds", "points", "ranges"};
  if (!is_drawable || std::ranges::find(drawable, request.what) == drawable.end()) {
    return Error{ErrorCode::kBadArgument,
                 "--format: only depth, nds, points and ranges of a configuration or a map can be "
                 "drawn as a picture"};
  }
  SIGHTLINE_ASSIGN(const PictureSources sources, target_of(flags) == Target::kMap
                                                     ? sources_of_map(flags)
                                                     : sources_of_config(flags));
  SIGHTLINE_ASSIGN(const std::string picture, draw_picture(request, sources));
  if (!flags.result.output.empty()) return put_result(flags.result, picture);
  std::fwrite(picture.data(), 1, picture.size(), stdout);
  return {};
}

Result<Table> table_of(const DumpFlags& flags) {
  switch (target_of(flags)) {
    case Target::kArtifact:
      return table_of_artifact(flags);
    case Target::kMap:
      return table_of_map(flags);
    case Target::kModel:
      return table_of_model(flags);
    case Target::kConfig:
      return table_of_config(flags);
  }
  SIGHTLINE_CHECK(false);
}

// The artifact that --what names, and of its rows those of looks that take a sample or the others.
Result<Table> wanted_table(DumpFlags flags) {
  const bool is_of_samples = flags.what.ends_with(kLooksSuffix);
  if (is_of_samples) flags.what.resize(flags.what.size() - kLooksSuffix.size());
  SIGHTLINE_ASSIGN(Table table, table_of(flags));
  if (target_of(flags) == Target::kArtifact) return table;
  keep_looks(is_of_samples ? KeptLooks::kSamples : KeptLooks::kRanges, table);
  return table;
}

Result<void> run_dump(const DumpFlags& flags) {
  if (target_of(flags) != Target::kArtifact && flags.what.empty()) {
    return Error{ErrorCode::kBadArgument,
                 "--what is required for a map, a model or a configuration"};
  }
  SIGHTLINE_TRY(try_result(flags.result));
  if (flags.format() == "png" || flags.format() == "svg") return dump_picture(flags);
  SIGHTLINE_ASSIGN(const TableFormat format, parse_table_format(flags.format()));
  SIGHTLINE_ASSIGN(Table table, wanted_table(flags));
  Result<void> kept;
  if (flags.site >= 0) kept = keep_site(flags.site, table);
  if (kept && !flags.box.empty()) kept = keep_box(flags.box, table);
  if (!kept) return kept;
  return put_result(flags.result, format_table(table, format));
}

}  // namespace

Verb dump_verb() {
  const auto flags = std::make_shared<DumpFlags>();
  Verb verb;
  verb.name = "dump";
  verb.summary = "Print any table of a map, or of any step of its compile";
  verb.details =
      "Results that are not in the cache are computed from the configuration. Numbers have full "
      "precision; column names contain the units. For each table of observation ranges, a second "
      "one with -looks at the end of its name contains the looks that take a sample.";
  verb.examples = {
      "sightline dump town.slmap --what ranges -o ranges.csv",
      "sightline dump town.slmap --what ranges-looks -o looks.csv",
      "sightline dump town.yaml --what factors --site 40",
      "sightline dump town.yaml --what depth --site 40 -o seen_from_40.png",
      "sightline dump town.slmap --what nds --box 0,-50,100,50 -o nds.svg",
      "sightline dump town.slmap --what ranges -o route.svg    # the tightest limit",
      "sightline dump city.slmodel --what recordings    # SHA-256 of its training recordings",
      "sightline dump town.yaml --what recordings       # SHA-256 of the recordings named there"};
  verb.flags = {{.names = "--what",
                 .value = "TABLE",
                 .help = "The table to print",
                 .target = &flags->what,
                 .choices = dumpable_names()},
                {.names = "--site",
                 .value = "SITE",
                 .help = "Only the rows of this site, counted from 0",
                 .target = &flags->site,
                 .minimum = 0},
                {.names = "--box",
                 .value = "X0,Y0,X1,Y1",
                 .help = "Only NDs inside, in map coordinates, m",
                 .target = &flags->box}};
  add_result_flags(
      verb, flags->result, kForms,
      "png and svg draw nds, depth (png only), points (png only) and ranges (svg only)");
  add_run_flags(verb, flags->run);
  verb.positionals.front().name = "TARGET";
  verb.positionals.front().help =
      "A map (.slmap), a model (.slmodel), a configuration (.yaml) or a cached artifact (.sla)";
  verb.run = [flags] { return exit_status_of(run_dump(*flags)); };
  return verb;
}

}  // namespace sightline
