#include "compiler/work/shared_work.h"
#include "compiler/driver/pipelines.h"

#include <algorithm>
#include <utility>

#include "compiler/pipeline/schedule.h"
#include "compiler/store/cache.h"

namespace sightline {
namespace {

std::string digest_of(const CompileConfig& config) {
  DigestBuilder builder;
  for (const EffectiveValue& value : effective_values(config)) {
    builder.add(std::string_view(value.section + "." + value.key + "=" + value.value + "\n"));
  }
  return to_hex(builder.finish());
}

Error changed(const std::string& what, const std::filesystem::path& plan) {
  return {ErrorCode::kMismatchedInputs,
          what +
              " changed since the plan was made; make it anew (what is finished and still right "
              "is found again)",
          plan_file_in(plan).string()};
}

}  // namespace

Result<NewPlan> new_plan(const std::filesystem::path& plan,
                         const std::filesystem::path& configuration,
                         const std::vector<std::string>& overrides,
                         const std::filesystem::path& model) {
  NewPlan made;
  made.file.folder = std::filesystem::current_path();
  made.file.configuration = std::filesystem::absolute(configuration);
  made.file.overrides = overrides;
  if (!model.empty()) made.file.model = std::filesystem::absolute(model);
  SharedWork& work = made.work;
  work.store = std::filesystem::absolute(store_in(plan));
  SIGHTLINE_ASSIGN(work.config, load_compile_config(made.file.configuration, overrides));
  made.file.values = digest_of(work.config);
  const bool is_given = !model.empty();
  work.compile = compile_plan(work.config, is_given ? ModelSource::kGiven : ModelSource::kTrained);
  SIGHTLINE_TRY(provide_drives(work.compile, work.store, work.artifacts));
  if (is_given) {
    SIGHTLINE_ASSIGN(ErrorModel given, read_model(made.file.model));
    work.artifacts.provide(work.compile.given_model, std::move(given));
    made.file.recordings.push_back(
        {"model", to_hex(work.artifacts.entry(work.compile.given_model).key)});
  }
  for (const RecordingCard& card : work.artifacts.get(work.compile.cards).cards) {
    made.file.recordings.push_back({card.role, to_hex(card.digest)});
  }
  return made;
}

Result<SharedWork> open_work(const std::filesystem::path& plan) {
  SIGHTLINE_ASSIGN(const PlanFile file, read_plan_file(plan));
  const std::filesystem::path here = std::filesystem::absolute(plan);
  std::error_code failure;
  std::filesystem::current_path(file.folder, failure);
  if (failure) {
    return Error{ErrorCode::kFileNotFound,
                 "the folder in which the plan was made is not there: " + failure.message(),
                 file.folder.string()};
  }
  SIGHTLINE_ASSIGN(NewPlan now, new_plan(here, file.configuration, file.overrides, file.model));
  if (now.file.values != file.values) return changed("the configuration", here);
  for (const PlannedRecording& recording : file.recordings) {
    if (std::ranges::find(now.file.recordings, recording) == now.file.recordings.end()) {
      return changed("'" + recording.role + "'", here);
    }
  }
  return std::move(now.work);
}

std::vector<AnyWire> outputs_of(const CompilePlan& compile, Stage stage) {
  const Plan& plan = compile.plan;
  std::vector<AnyWire> outputs;
  for (const std::size_t index :
       steps_for(plan, reported_artifacts(compile), [](AnyWire) { return false; })) {
    const PassStep& step = plan.steps()[index];
    if (can_be_kept(plan, step) && step.stage == stage) outputs.push_back({step.output});
  }
  return outputs;
}

std::vector<AnyWire> share_of(const std::vector<AnyWire>& outputs, const WorkShare& share) {
  const auto begin =
      outputs.begin() + static_cast<std::ptrdiff_t>(outputs.size() * share.number / share.of);
  const auto end =
      outputs.begin() + static_cast<std::ptrdiff_t>(outputs.size() * (share.number + 1) / share.of);
  return {begin, end};
}

RunOptions options_in(const SharedWork& work, Stage stage) {
  RunOptions options;
  options.seed = static_cast<std::uint64_t>(work.config.annotation.seed);
  options.cache_directory = work.store;
  options.may_run = [&plan = work.compile.plan, stage](const std::string& name) {
    return std::ranges::any_of(plan.steps(), [&](const PassStep& step) {
      return step.name == name && step.stage == stage;
    });
  };
  return options;
}

std::vector<StepState> states_of(const SharedWork& work) {
  const Plan& plan = work.compile.plan;
  const ArtifactCache cache = ArtifactCache::to_look_at(work.store);
  std::vector<StepState> states;
  for (const PlannedRun& run : planned_runs(plan, reported_artifacts(work.compile),
                                            options_in(work, Stage::kLink), work.artifacts)) {
    if (!run.is_kept) continue;
    StepState state{plan.steps()[run.step].stage, run.name, cache.has(run.name, run.key)};
    if (const auto parts = cache.part_count(run.name, run.key)) {
      state.parts = parts->all;
      state.parts_there = parts->there;
    }
    states.push_back(std::move(state));
  }
  return states;
}

}  // namespace sightline
