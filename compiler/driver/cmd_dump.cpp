#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>

#include "compiler/base/atomic_file.h"
#include "compiler/driver/commands.h"
#include "compiler/driver/dump_picture.h"
#include "compiler/driver/pipelines.h"
#include "compiler/driver/run_flags.h"
#include "compiler/driver/table_rows.h"
#include "formats/map/map_reader.h"

namespace sightline {
namespace {

struct DumpFlags {
  RunFlags run;  // config_file is the target: a configuration, a map, a model or an artifact
  std::string what;
  std::string format = "text";
  int site = -1;
  std::string box;  // empty: everything
};

// What a table is called on the command line, and the artifact that holds it.
struct Dumpable {
  std::string what;
  std::string artifact;
};

const std::vector<Dumpable> kDumpables = {{"nds", "ndt-map"},
                                          {"sites", "sites"},
                                          {"factors", "factor-table"},
                                          {"measured", "measured-error"},
                                          {"predicted", "predicted-error"},
                                          {"ranges", "range-table"},
                                          {"trajectory", "mapping/trajectory"},
                                          {"depth", "depth-images"},
                                          {"drive", "mapping/drive"},
                                          {"points", "surface-points"},
                                          {"surface", "surface"},
                                          {"model", "error-model"},
                                          {"recordings", "recording-cards"},
                                          {"evaluation", "evaluation"}};

std::vector<std::string> dumpable_names() {
  std::vector<std::string> names;
  for (const Dumpable& dumpable : kDumpables) names.push_back(dumpable.what);
  return names;
}

Result<Table> table_of_map(const DumpFlags& flags) {
  const Result<CompiledMap> map = read_map(flags.run.config_file);
  if (!map) return map.error();
  Result<Table> table = dump(*map, flags.what);
  if (table) return table;
  Error error = table.error();
  error.file = flags.run.config_file;
  error.message += "; everything else can be dumped from the configuration that compiled it";
  return error;
}

Result<Table> table_of_model(const DumpFlags& flags) {
  const Result<ErrorModel> model = read_model(flags.run.config_file);
  if (!model) return model.error();
  if (flags.what == "model") return dump(*model);
  if (flags.what == "recordings") return recordings_table(*model);
  return Error{ErrorCode::kBadArgument, "--what: a model holds the tables model and recordings",
               flags.run.config_file, ""};
}

// Runs the compile (from the cache where it can) up to the pass that makes the artifact.
Result<ArtifactSet> artifacts_up_to(const std::string& artifact, const DumpFlags& flags) {
  const Result<CompileConfig> config =
      load_compile_config(flags.run.config_file, flags.run.overrides);
  if (!config) return config.error();
  const std::vector<PassStep> steps = compile_pipeline(*config);
  const auto step = std::ranges::find(steps, artifact, &PassStep::output);
  SIGHTLINE_CHECK(step != steps.end());
  RunFlags run = flags.run;
  run.stop_after = step->name;
  ArtifactSet artifacts;
  const Result<void> provided = provide_drives(*config, artifacts);
  if (!provided) return provided.error();
  const Result<std::vector<StepReport>> reports = run_steps(steps, run, *config, artifacts);
  if (!reports) return reports.error();
  return artifacts;
}

std::string artifact_of(const std::string& what) {
  return std::ranges::find(kDumpables, what, &Dumpable::what)->artifact;
}

// Of every recording that the configuration names; reads files and runs no pass.
Result<Table> recordings_of_config(const DumpFlags& flags) {
  const Result<CompileConfig> config =
      load_compile_config(flags.run.config_file, flags.run.overrides);
  if (!config) return config.error();
  ArtifactSet artifacts;
  Result<void> provided = provide_drives(*config, artifacts);
  if (provided && !config->evaluation.scans.empty()) {
    provided = provide_evaluation(*config, artifacts);
  }
  if (!provided) return provided.error();
  return dump(recording_cards(*config, artifacts));
}

Result<Table> table_of_config(const DumpFlags& flags) {
  if (flags.what == "recordings") return recordings_of_config(flags);
  const std::string artifact = artifact_of(flags.what);
  const Result<ArtifactSet> artifacts = artifacts_up_to(artifact, flags);
  if (!artifacts) return artifacts.error();
  const ArtifactSet::Entry& entry = artifacts->entry(artifact);
  return entry.type->print(entry.value.get());
}

Result<PictureSources> points_of_config(const DumpFlags& flags) {
  const Result<ArtifactSet> artifacts = artifacts_up_to("surface-points", flags);
  if (!artifacts) return artifacts.error();
  PictureSources sources;
  sources.points =
      std::make_shared<const SurfacePoints>(artifacts->get<SurfacePoints>("surface-points"));
  return sources;
}

Result<PictureSources> sources_of_config(const DumpFlags& flags) {
  if (flags.what == "points") return points_of_config(flags);
  const bool is_depth = flags.what == "depth";
  // Sites are made after NDs and before depth images.
  const Result<ArtifactSet> artifacts = artifacts_up_to(is_depth ? "depth-images" : "sites", flags);
  if (!artifacts) return artifacts.error();
  PictureSources sources;
  if (is_depth) {
    sources.depth =
        std::make_shared<const DepthImages>(artifacts->get<DepthImages>("depth-images"));
  }
  sources.ndt = std::make_shared<const NdtMap>(artifacts->get<NdtMap>("ndt-map"));
  sources.sites = artifacts->get<Sites>("sites");
  return sources;
}

Result<PictureSources> sources_of_map(const DumpFlags& flags) {
  Result<CompiledMap> map = read_map(flags.run.config_file);
  if (!map) return map.error();
  PictureSources sources;
  sources.ndt = std::make_shared<const NdtMap>(std::move(map->ndt));
  sources.sites = std::move(map->sites);
  return sources;
}

// An artifact file of the cache says itself what it is.
Result<Table> table_of_artifact(const DumpFlags& flags) {
  const Result<std::vector<std::byte>> bytes = read_file(flags.run.config_file);
  if (!bytes) return bytes.error();
  CompileConfig config;
  config.localization.scans = "any";
  for (const PassStep& step : compile_pipeline(config)) {
    if (!step.output_type->read) continue;
    const Result<std::shared_ptr<const void>> artifact = step.output_type->read(*bytes);
    if (artifact) return step.output_type->print(artifact->get());
    if (artifact.error().code == ErrorCode::kBadLayer) continue;  // another type's
    Error error = artifact.error();
    error.file = flags.run.config_file;
    return error;
  }
  return Error{ErrorCode::kUnsupportedFormat, "no pass of this program makes such an artifact",
               flags.run.config_file, ""};
}

enum class Target { kConfig, kMap, kModel, kArtifact };

Target target_of(const DumpFlags& flags) {
  const std::filesystem::path extension = std::filesystem::path(flags.run.config_file).extension();
  if (extension == ".sla") return Target::kArtifact;
  if (extension == ".slmodel") return Target::kModel;
  return extension == ".slmap" ? Target::kMap : Target::kConfig;
}

Result<void> dump_picture(const DumpFlags& flags) {
  PictureWish wish;
  wish.what = flags.what;
  wish.format = flags.format == "svg" ? PictureFormat::kSvg : PictureFormat::kPng;
  wish.site = flags.site;
  if (!flags.box.empty()) {
    const Result<MapBox> box = parse_box(flags.box);
    if (!box) return box.error();
    wish.box = *box;
  }
  const bool is_drawable =
      target_of(flags) == Target::kMap || target_of(flags) == Target::kConfig;
  if (!is_drawable ||
      (wish.what != "depth" && wish.what != "nds" && wish.what != "points")) {
    return Error{ErrorCode::kBadArgument,
                 "--format: only depth, nds and points of a configuration or a map can be drawn",
                 "", ""};
  }
  const Result<PictureSources> sources =
      target_of(flags) == Target::kMap ? sources_of_map(flags) : sources_of_config(flags);
  if (!sources) return sources.error();
  const Result<std::string> picture = draw_picture(wish, *sources);
  if (!picture) return picture.error();
  std::fwrite(picture->data(), 1, picture->size(), stdout);
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

Result<void> run_dump(const DumpFlags& flags) {
  if (target_of(flags) != Target::kArtifact && flags.what.empty()) {
    return Error{ErrorCode::kBadArgument,
                 "--what is required for a map, a model or a configuration", "", ""};
  }
  if (flags.format == "png" || flags.format == "svg") return dump_picture(flags);
  const Result<TableFormat> format = parse_table_format(flags.format);
  if (!format) return format.error();
  Result<Table> table = table_of(flags);
  if (!table) return table.error();
  Result<void> kept;
  if (flags.site >= 0) kept = keep_site(flags.site, *table);
  if (kept && !flags.box.empty()) kept = keep_box(flags.box, *table);
  if (!kept) return kept;
  std::fputs(format_table(*table, *format).c_str(), stdout);
  return {};
}

}  // namespace

Verb dump_verb() {
  const auto flags = std::make_shared<DumpFlags>();
  Verb verb;
  verb.name = "dump";
  verb.summary = "Print every number of a map or of any step on the way to it";
  verb.details =
      "What is not in the cache is computed from the configuration. Numbers have full precision; "
      "units stand in the column names. Of nds, --format also takes png and svg, of depth and "
      "points png.";
  verb.examples = {
      "sightline dump town.slmap --what ranges --format csv > ranges.csv",
      "sightline dump town.yaml --what factors --site 40",
      "sightline dump town.yaml --what depth --site 40 --format png > seen_from_40.png",
      "sightline dump town.slmap --what nds --box 0,-50,100,50 --format svg > nds.svg",
      "sightline dump city.slmodel --what recordings    # SHA-256 of what it was trained on",
      "sightline dump town.yaml --what recordings       # the same of recordings at hand"};
  verb.flags = {{.names = "--what",
                 .value = "TABLE",
                 .help = "The table to print",
                 .target = &flags->what,
                 .choices = dumpable_names()},
                {.names = "--format",
                 .value = "FORMAT",
                 .help = "Form of the output",
                 .target = &flags->format,
                 .choices = {"text", "csv", "json", "png", "svg"}},
                {.names = "--site",
                 .value = "SITE",
                 .help = "Only the rows of this site, counted from 0",
                 .target = &flags->site,
                 .minimum = 0},
                {.names = "--box",
                 .value = "X0,Y0,X1,Y1",
                 .help = "Only NDs inside, in map coordinates, m",
                 .target = &flags->box}};
  add_run_flags(verb, flags->run);
  verb.positionals.front().name = "TARGET";
  verb.positionals.front().help =
      "A map (.slmap), a model (.slmodel), a configuration (.yaml) or a cached artifact (.sla)";
  verb.run = [flags] { return exit_status_of(run_dump(*flags)); };
  return verb;
}

}  // namespace sightline
