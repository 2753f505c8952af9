#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/console/console.h"
#include "compiler/cli/console/written.h"
#include "compiler/cli/run_flags.h"
#include "compiler/commands/commands.h"
#include "compiler/config/config_file.h"
#include "compiler/driver/configuration.h"
#include "compiler/driver/pipelines.h"
#include "compiler/driver/provide_inputs.h"
#include "compiler/views/text/map_summary_text.h"
#include "compiler/views/verdict/verdict_text.h"
#include "formats/annotation/driven_places.h"
#include "formats/base/files/atomic_file.h"
#include "formats/model/place_count.h"
#include "passes/model/choose_ranges.h"
#include "passes/model/train_model.h"

namespace sightline {
namespace {

struct TrainFlags {
  RunFlags run;
  std::vector<std::string> configs;
  std::string output;
  std::string format = "text";
  bool with_evaluation = false;
  bool shows_tables = false;
  bool is_forced = false;
};

// A place, still without a name, and a key that names everything its numbers were made of.
struct MeasuredPlace {
  ByFamily<DrivenPlace> place;
  Digest key{};
};

// Whether --stop-after names a pass of the places: then no model is trained.
bool stops_early(const TrainFlags& flags) {
  return !flags.run.stop_after.empty() && flags.run.stop_after != kTrainModel.name;
}

Result<CompileConfig> load_config(const TrainFlags& flags, const std::string& file) {
  Result<CompileConfig> config = load_compile_config(file, flags.run.overrides);
  if (config && flags.with_evaluation && config->evaluation.scans.empty()) {
    return Error{ErrorCode::kMissingKey,
                 "evaluation.scans: --with-evaluation needs a second drive, and none is named",
                 file};
  }
  if (config && config->has_map() && config->localization.scans.empty()) {
    return Error{ErrorCode::kMissingKey,
                 "localization.scans: a model learns from the errors of a drive; name one for this "
                 "finished map",
                 file};
  }
  if (config && flags.with_evaluation && config->imports_errors() != config->imports_evaluation()) {
    return Error{
        ErrorCode::kMissingKey,
        "import-errors: with --with-evaluation both drives of a place need errors of the same "
        "localizer; name both files, or none",
        file};
  }
  return config;
}

// A place whose recordings are open, and what is computed for it.
struct OpenPlace {
  CompileConfig config;
  RunFlags run;
  CompilePlan compile;
  std::vector<Wire<ByFamily<MeasuredError>>>
      drives;  // none where a list of them is measured together
  ArtifactSet artifacts;
};

Result<OpenPlace> open_place(const TrainFlags& flags, const std::string& file) {
  OpenPlace place;
  SIGHTLINE_ASSIGN(place.config, load_config(flags, file));
  place.run = flags.run;
  place.run.config_file = file;
  if (!stops_early(flags)) place.run.stop_after.clear();  // the places' plans train models too
  place.compile = compile_plan(place.config);
  if (!place.compile.measured_drives.is_connected()) {
    place.drives.push_back(place.compile.measured);
  }
  if (flags.with_evaluation) {
    place.compile.learns_from_evaluation = true;
    place.drives.push_back(measure_evaluation_drive(place.config, place.compile));
  }
  SIGHTLINE_TRY(provide_drives(place.compile, cache_directory(place.run), place.artifacts));
  return place;
}

std::vector<AnyWire> wanted_of(const OpenPlace& place) {
  const CompilePlan& compile = place.compile;
  std::vector<AnyWire> wanted = {compile.sites, compile.factors, compile.identified};
  if (compile.measured_drives.is_connected()) wanted.emplace_back(compile.measured_drives);
  wanted.insert(wanted.end(), place.drives.begin(), place.drives.end());
  return wanted;
}

Result<void> run_place(OpenPlace& place) {
  print_note("place " + place.run.config_file);
  SIGHTLINE_TRY(
      run_steps(place.compile.plan, wanted_of(place), place.run, place.config, place.artifacts));
  return {};
}

Result<MeasuredPlace> measure_place(OpenPlace place) {
  SIGHTLINE_TRY(run_place(place));
  const CompilePlan& compile = place.compile;
  const ArtifactSet& artifacts = place.artifacts;
  RecordingCards recordings = artifacts.get(compile.identified);
  std::vector<ByFamily<MeasuredError>> drives;
  if (compile.measured_drives.is_connected()) {
    const MeasuredDrives& several = artifacts.get(compile.measured_drives);
    drives = several.drives;
    recordings = without_left_out(recordings, several);
  }
  for (const Wire<ByFamily<MeasuredError>> drive : place.drives) {
    drives.push_back(artifacts.get(drive));
  }
  MeasuredPlace measured;
  const auto of_family = [&](const FactorTable& factors,
                             const std::vector<MeasuredError>& errors) -> Result<DrivenPlace> {
    return DrivenPlace{"", artifacts.get(compile.sites), factors, errors, recordings};
  };
  SIGHTLINE_ASSIGN(measured.place, each_family(of_family, artifacts.get(compile.factors),
                                               join_families(std::move(drives))));
  DigestBuilder key;
  key.add(sha256(to_bytes(recordings)));
  for (const AnyWire wire : wanted_of(place)) key.add(artifacts.entry(wire).key);
  measured.key = key.finish();
  return measured;
}

// All places, a key that names everything they were made of, and the first configuration, which
// sets how the model is trained.
struct TrainingPlaces {
  ByFamily<DrivenPlaces> places;
  Digest key{};
  CompileConfig first_config;
};

// Every configuration and recording is opened before the first is measured, which takes minutes.
Result<std::vector<OpenPlace>> open_places(const TrainFlags& flags) {
  std::vector<OpenPlace> open;
  for (const std::string& file : flags.configs) {
    SIGHTLINE_ASSIGN(OpenPlace place, open_place(flags, file));
    open.push_back(std::move(place));
  }
  return open;
}

Result<TrainingPlaces> measure_places(const TrainFlags& flags, std::vector<OpenPlace> open) {
  TrainingPlaces training;
  std::vector<ByFamily<DrivenPlace>> places;
  training.first_config = open.front().config;
  DigestBuilder key;
  const std::vector<std::string> names = place_names(flags.configs);
  for (std::size_t i = 0; i < open.size(); ++i) {
    SIGHTLINE_ASSIGN(MeasuredPlace measured, measure_place(std::move(open[i])));
    visit_families(measured.place, [&](DrivenPlace& place) { place.name = names[i]; });
    key.add(names[i]);
    key.add(measured.key);
    places.push_back(std::move(measured.place));
  }
  ByFamily<std::vector<DrivenPlace>> all = join_families(std::move(places));
  training.places.ranges.places = std::move(all.ranges);
  if (all.samples) training.places.samples = DrivenPlaces{std::move(*all.samples)};
  training.key = key.finish();
  return training;
}

// Each place up to the pass that --stop-after names.
Result<void> run_places(const TrainFlags& flags, std::vector<OpenPlace> open) {
  for (OpenPlace& opened : open) {
    OpenPlace place = std::move(opened);
    SIGHTLINE_TRY(run_place(place));
  }
  say_stopped(flags.run, "no model is written");
  return {};
}

void print_model(const TrainFlags& flags, const CompileConfig& config,
                 const ByFamily<ErrorModel>& model) {
  if (flags.run.is_quiet) return;
  if (flags.format == "json") return print_data(json_text(model_json(model)));
  print_written(flags.output, "an error model of " + places_text(model.ranges.card));
  for (const std::string& promise :
       promises_of(config.passes.options(kChooseRanges), model.ranges)) {
    print_text(promise + "\n");
  }
  if (flags.shows_tables) return print_text("\n" + to_text(model));
  print_text(concat("Next: sightline compile CONFIG -o MAP --model ", flags.output,
                    "; sightline inspect ", flags.output, " shows the model card\n"));
}

Result<void> train(const TrainFlags& flags) {
  SIGHTLINE_TRY(try_output(flags.output, if_exists(flags.is_forced)));
  SIGHTLINE_ASSIGN(std::vector<OpenPlace> open, open_places(flags));
  if (stops_early(flags)) return run_places(flags, std::move(open));
  SIGHTLINE_ASSIGN(TrainingPlaces training, measure_places(flags, std::move(open)));
  const CompileConfig& config = training.first_config;
  Plan plan(config.passes);
  const auto places = plan.input<ByFamily<DrivenPlaces>>("places");
  const Wire<ByFamily<ErrorModel>> learnt = plan.run(kTrainModel, places);
  ArtifactSet artifacts;
  artifacts.provide(places, std::move(training.places), training.key);
  RunFlags run = flags.run;
  run.config_file = flags.configs.front();
  SIGHTLINE_TRY(run_steps(plan, {}, run, config, artifacts));
  const ByFamily<ErrorModel>& model = artifacts.get(learnt);
  SIGHTLINE_TRY(write_file_atomically(flags.output, to_bytes(model), if_exists(flags.is_forced)));
  print_model(flags, config, model);
  return {};
}

}  // namespace

Verb train_verb() {
  const auto flags = std::make_shared<TrainFlags>();
  Verb verb;
  verb.name = "train";
  verb.summary = "Train an error model on drives of several places, for maps of others";
  verb.details =
      "Each configuration is one place: its mapping drive makes the map, and its localization "
      "drives are measured in it. Measurements are cached, so one more place or drive adds only "
      "its own time. The model card (`sightline inspect`, or --tables) is cross-validated: each "
      "place is predicted by a model of the others.\n\n"
      "Of places with two drives or more, the model also learns to predict one drive from the "
      "measurements of others. --with-evaluation also uses the evaluation drive of each place, "
      "which then cannot judge maps that this model annotates.\n\n"
      "A promise is about the next drive. It is computed from drives that the model was not "
      "trained on: each place is predicted by a model of the others or, if there is one place "
      "with two drives, each drive by a model of the other. Places that share a recording count "
      "as one.";
  verb.examples = {"sightline train north.yaml south.yaml old-town.yaml -o city.slmodel",
                   "sightline train town-*/town.yaml -o towns.slmodel --with-evaluation",
                   "sightline compile street.yaml -o street.slmap --model city.slmodel",
                   "sightline inspect city.slmodel    # the model card"};
  verb.positionals = {{.name = "CONFIG",
                       .help = "YAML configurations, one of each place",
                       .target = &flags->configs}};
  verb.flags = {required_output_flag(flags->output, "The model to write (.slmodel)"),
                force_flag(flags->is_forced),
                {.names = "--format",
                 .value = "FORMAT",
                 .help = "Form of what is printed of the model; json: as "
                         "schemas/inspect.schema.json describes it",
                 .target = &flags->format,
                 .choices = {"text", "json"}},
                {.names = "--with-evaluation",
                 .help = "Also learn from the evaluation drive of each place",
                 .target = &flags->with_evaluation},
                {.names = "--tables",
                 .help = "Also print the model card on stdout",
                 .target = &flags->shows_tables}};
  add_flags_of_every_run(verb, flags->run);
  verb.run = [flags] { return exit_status_of(train(*flags)); };
  return verb;
}

}  // namespace sightline
