#include "compiler/pipeline/runner.h"

#include <algorithm>
#include <chrono>
#include <mutex>
#include <new>
#include <optional>
#include <set>
#include <utility>

#include "compiler/pipeline/process_cost.h"
#include "compiler/pipeline/schedule.h"
#include "compiler/store/cache.h"

namespace sightline {
namespace {

struct Stamp {
  std::chrono::steady_clock::time_point wall = std::chrono::steady_clock::now();
  double cpu_s = 0.0;
};

Error named(Error error, const std::string& pass) {
  const std::string place = "pass " + pass;
  if (error.place.empty())
    error.place = place;
  else if (error.place != place)
    error.message += concat(" [pass ", pass, "]");
  return error;
}

class Runner {
 public:
  Runner(const Plan& plan, const RunOptions& options, const RunObserver& observer,
         ArtifactSet& artifacts, std::vector<Scheduled> list, ArtifactCache cache)
      : plan_(plan),
        options_(options),
        observer_(observer),
        artifacts_(artifacts),
        list_(std::move(list)),
        cache_(std::move(cache)) {}

  [[nodiscard]] const std::vector<Scheduled>& list() const { return list_; }
  [[nodiscard]] const PassStep& step_of(const Scheduled& scheduled) const {
    return plan_.steps()[scheduled.step];
  }

  // Error: work-missing.
  [[nodiscard]] Result<void> check_may_run() const {
    std::string missing;
    for (const Scheduled& scheduled : list_) {
      const std::string& name = step_of(scheduled).name;
      if (scheduled.runs() && !may_run(scheduled)) missing += (missing.empty() ? "" : ", ") + name;
    }
    if (missing.empty()) return {};
    return work_missing(missing);
  }

  // Before hours of work rather than after its first step. Errors: cannot-write.
  Result<void> check_cache() {
    const Result<void> writable = cache_.check_writable();
    if (writable || options_.must_store) return writable;
    has_failed_to_store_ = true;
    if (observer_.warning) observer_.warning("cache", cannot_store_text(writable.error()));
    return {};
  }

  Result<StepReport> run(const Scheduled& scheduled) {
    StepReport report;
    report.name = step_of(scheduled).name;
    const Stamp begin{.cpu_s = process_cpu_s()};
    if (scheduled.runs()) let_go_of_wholes(scheduled);
    reset_peak_memory();
    if (scheduled.is_stored) cache_.mark_used(report.name, scheduled.key.key);
    if (scheduled.is_needed && !is_lazy(scheduled)) {
      SIGHTLINE_TRY(obtain(scheduled, *step_of(scheduled).output_type, report));
    } else {
      report.from_cache = true;
      report.reason = scheduled.is_stored ? "unchanged" : kNotNeeded;
    }
    if (report.from_cache) repeat_warnings(scheduled, report);
    let_go(scheduled);
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin.wall;
    report.wall_s = wall.count();
    report.cpu_s = process_cpu_s() - begin.cpu_s;
    report.peak_memory_mib = peak_memory_mib();
    return report;
  }

  // What is wanted, for those who look at it: when no step takes any other artifact any more.
  Result<void> make_wanted_whole() {
    if (!options_.keeps_wanted) return {};
    for (const Scheduled& scheduled : list_) {
      const AnyWire output{step_of(scheduled).output};
      if (!scheduled.is_wanted || !artifacts_.has(output)) continue;
      ArtifactSet::Entry entry = artifacts_.entry(output);
      const ArtifactType& whole = *plan_.artifact(output).type;
      SIGHTLINE_ASSIGN(entry.value, in_form(entry, whole));
      entry.type = &whole;
      artifacts_.put(output, std::move(entry));
    }
    return {};
  }

 private:
  // What another step takes is loaded when it is taken: until then memory has no need of it.
  [[nodiscard]] static bool is_lazy(const Scheduled& scheduled) {
    return scheduled.is_stored && !scheduled.is_wanted;
  }

  // A step that keeps no output in the cache is always run.
  [[nodiscard]] bool may_run(const Scheduled& scheduled) const {
    return !scheduled.is_kept || !options_.may_run || options_.may_run(step_of(scheduled).name);
  }

  static Error work_missing(const std::string& names) {
    return {ErrorCode::kWorkMissing, "not finished yet: " + names};
  }

  // Loads the output of a step, in this form, or makes it. What the step had to say when it was
  // made is not repeated.
  Result<void> obtain(const Scheduled& scheduled, const ArtifactType& form, StepReport& report) {
    const PassStep& step = step_of(scheduled);
    std::shared_ptr<const void> output;
    if (scheduled.is_kept) {
      SIGHTLINE_ASSIGN(output, from_cache(scheduled, form, report));
    }
    report.from_cache = output != nullptr;
    if (output) {
      report.reason = "unchanged";
    } else {
      report.reason = reason_to_run(cache_.last_record(step.name), scheduled.key.record);
      if (!may_run(scheduled)) return work_missing(step.name);
      SIGHTLINE_TRY(obtain_inputs(step));
      Result<std::shared_ptr<const void>> made = make(scheduled, report);
      if (!made) return named(made.error(), step.name);
      output = *made;
    }
    SIGHTLINE_TRY(heeded(cache_.store_record(step.name, scheduled.key.record), step, report));
    const ArtifactType* type = report.from_cache ? &form : step.output_type;
    artifacts_.put({step.output}, {type, output, scheduled.key.key});
    return {};
  }

  // Those that are not there are in the cache, unless an object turned out to be damaged.
  Result<void> obtain_inputs(const PassStep& step) {
    for (std::size_t i = 0; i < step.inputs.size(); ++i) {
      const std::size_t input = step.inputs[i];
      if (artifacts_.has({input})) continue;
      const auto maker = std::ranges::find_if(
          list_, [&](const Scheduled& scheduled) { return step_of(scheduled).output == input; });
      SIGHTLINE_CHECK(maker != list_.end());
      StepReport report;
      SIGHTLINE_TRY(obtain(*maker, *step.input_types[i], report));
    }
    return {};
  }

  // Of what this step is the last to take: where it takes a form of what is whole in memory, it is
  // read from the cache, so that memory does not hold both.
  void let_go_of_wholes(const Scheduled& taking) {
    for (const Scheduled& maker : list_) {
      const std::size_t output = step_of(maker).output;
      if (!artifacts_.has({output}) || artifacts_.entry({output}).type->is_form) continue;
      if (takes_a_form(step_of(taking), output) && maker.is_kept && !is_held(maker) &&
          !is_taken_behind(taking, output) && cache_.has(step_of(maker).name, maker.key.key)) {
        artifacts_.remove({output});
      }
    }
  }

  // And nothing but forms of it.
  static bool takes_a_form(const PassStep& step, std::size_t artifact) {
    bool takes = false;
    for (std::size_t i = 0; i < step.inputs.size(); ++i) {
      if (step.inputs[i] != artifact) continue;
      if (!step.input_types[i]->is_form) return false;
      takes = true;
    }
    return takes;
  }

  [[nodiscard]] bool is_held(const Scheduled& scheduled) const {
    return scheduled.is_wanted && options_.keeps_wanted;
  }

  [[nodiscard]] bool is_taken_behind(const Scheduled& step, std::size_t artifact) const {
    return std::ranges::any_of(list_, [&](const Scheduled& later) {
      return later.step > step.step && later.is_needed &&
             std::ranges::find(step_of(later).inputs, artifact) != step_of(later).inputs.end();
    });
  }

  // What no later step takes and no caller wants.
  void let_go(const Scheduled& done) {
    for (const Scheduled& scheduled : list_) {
      if (scheduled.step > done.step) break;
      if (is_held(scheduled)) continue;
      const std::size_t output = step_of(scheduled).output;
      if (!is_taken_behind(done, output)) artifacts_.remove({output});
    }
  }

  // In the forms that the step takes.
  using Inputs = std::vector<std::shared_ptr<const void>>;
  Result<Inputs> inputs_of(const PassStep& step) const {
    Inputs inputs;
    for (std::size_t i = 0; i < step.inputs.size(); ++i) {
      SIGHTLINE_ASSIGN(std::shared_ptr<const void> input,
                       in_form(artifacts_.entry({step.inputs[i]}), *step.input_types[i]));
      inputs.push_back(std::move(input));
    }
    return inputs;
  }

  // Nothing where there is no such object or it is of no use.
  Result<std::shared_ptr<const void>> from_cache(const Scheduled& scheduled,
                                                 const ArtifactType& form, StepReport& report) {
    const PassStep& step = step_of(scheduled);
    const auto refuse = [&](const Error& error) -> std::shared_ptr<const void> {
      note(step, report,
           "a cache file is invalid, its content is computed again: " + to_string(error));
      return nullptr;
    };
    const Result<std::optional<StoredBytes>> found = cache_.open(step.name, scheduled.key.key);
    if (!found) return refuse(found.error());
    if (!*found) return std::shared_ptr<const void>();
    Result<std::shared_ptr<const void>> artifact = form.read(**found);
    if (!artifact) return refuse(artifact.error());
    if (!step.reattach) return *artifact;
    SIGHTLINE_TRY(obtain_inputs(step));
    SIGHTLINE_ASSIGN(const Inputs inputs, inputs_of(step));
    return step.reattach(*artifact, inputs);
  }

  // A cache that cannot be written (read-only, another user's, full) costs the next run time, not
  // this one its map.
  Result<void> heeded(const Result<void>& stored, const PassStep& step, StepReport& report) {
    if (stored || options_.must_store || stored.error().code == ErrorCode::kOutOfMemory) {
      return stored;
    }
    if (!std::exchange(has_failed_to_store_, true))
      note(step, report, cannot_store_text(stored.error()));
    return {};
  }

  Result<std::shared_ptr<const void>> make(const Scheduled& scheduled, StepReport& report) {
    const PassStep& step = step_of(scheduled);
    const StepKey& key = scheduled.key;
    SIGHTLINE_ASSIGN(const Inputs inputs, inputs_of(step));
    PassContext ctx;
    ctx.threads = options_.threads;
    ctx.seed = options_.seed;
    ctx.share = options_.share;
    ctx.progress_sink = observer_.progress;
    std::mutex mutex;
    ctx.saved_part = [&](const PartName& part) -> ArtifactCache::Content {
      Result<ArtifactCache::Content> found = cache_.load_part(step.name, part_key(key, part));
      if (found) return std::move(*found);
      const std::lock_guard<std::mutex> lock(mutex);
      note(step, report,
           "a cache file is invalid, its content is computed again: " + to_string(found.error()));
      return std::nullopt;
    };
    ctx.part_sink = [&](const PartName& part, std::span<const std::byte> bytes) {
      cache_.store_part(step.name, part_key(key, part), bytes);
    };
    std::size_t lists = 0;
    ctx.parts_sink = [&](std::span<const PartName> parts) {
      std::vector<Digest> keys;
      for (const PartName& part : parts) keys.push_back(part_key(key, part));
      cache_.store_part_list(step.name, key.key, keys, lists++);
    };
    std::vector<std::string> said;
    ctx.warning_sink = [&](const std::string& message) {
      const std::lock_guard<std::mutex> lock(mutex);
      if (std::ranges::find(said, message) != said.end()) return;  // of ranges, then of looks
      said.push_back(message);
      note(step, report, message);
    };
    ctx.information_sink = [&](const std::string& message) {
      const std::lock_guard<std::mutex> lock(mutex);
      if (observer_.information) observer_.information(step.name, message);
    };
    SIGHTLINE_ASSIGN(std::shared_ptr<const void> output, step.run(ctx, inputs));
    SIGHTLINE_TRY(step.output_type->check(output.get()));
    SIGHTLINE_TRY(heeded(cache_.store_warnings(step.name, key.key, said), step, report));
    if (cache_.is_enabled() && scheduled.is_kept) {
      const auto write = [&](const ByteSink& sink) {
        return step.output_type->write(output.get(), sink);
      };
      SIGHTLINE_TRY(heeded(cache_.store(step.name, key.key, write), step, report));
    }
    return output;
  }

  void repeat_warnings(const Scheduled& scheduled, StepReport& report) const {
    const PassStep& step = step_of(scheduled);
    for (const std::string& message : cache_.load_warnings(step.name, scheduled.key.key)) {
      note(step, report, message);
    }
  }

  void note(const PassStep& step, StepReport& report, const std::string& message) const {
    report.warnings.push_back(message);
    if (observer_.warning) observer_.warning(step.name, message);
  }

  const Plan& plan_;
  const RunOptions& options_;
  const RunObserver& observer_;
  ArtifactSet& artifacts_;
  std::vector<Scheduled> list_;
  ArtifactCache cache_;
  bool has_failed_to_store_ = false;
};

Result<void> check_names(const Plan& plan, const RunOptions& options) {
  std::vector<std::string> known;
  for (const PassStep& step : plan.steps()) known.push_back(step.name);
  std::vector<std::string> asked = options.print_after;
  if (!options.stop_after.empty()) asked.push_back(options.stop_after);
  for (const std::string& name : asked) {
    if (std::ranges::find(known, name) != known.end()) continue;
    const std::string near = nearest_name(name, known);
    return Error{ErrorCode::kUnknownPass, concat("no pass is called '", name, "'",
                                                 (near.empty() ? "; 'sightline passes' lists them"
                                                               : "; did you mean " + near + "?"))};
  }
  return {};
}

// A plan that is run without what it takes from outside is our own mistake: found before hours of
// work, not after them.
void check_inputs(const Plan& plan, const std::vector<Scheduled>& list,
                  const ArtifactSet& artifacts) {
  std::set<std::size_t> made;
  for (const Scheduled& scheduled : list) {
    const PassStep& step = plan.steps()[scheduled.step];
    for (const std::size_t input : step.inputs) {
      SIGHTLINE_CHECK(made.contains(input) || artifacts.has({input}));
    }
    made.insert(step.output);
  }
}

Result<void> print_if_asked(const PassStep& step, const RunOptions& options,
                            const RunObserver& observer, const ArtifactSet& artifacts) {
  if (!observer.printed ||
      std::ranges::find(options.print_after, step.name) == options.print_after.end()) {
    return {};
  }
  const ArtifactSet::Entry& output = artifacts.entry({step.output});
  SIGHTLINE_ASSIGN(const Table table, output.type->print(output.value.get()));
  observer.printed(step.name, table);
  return {};
}

}  // namespace

std::string cannot_store_text(const Error& error) {
  return concat(
      "the cache cannot be written, so the next run computes the same again; --cache FOLDER names "
      "another one, --no-cache uses none: ",
      to_string(error));
}

Result<void> run_plan(const Plan& plan, const std::vector<AnyWire>& wanted,
                      const RunOptions& options, const RunObserver& observer,
                      ArtifactSet& artifacts, std::vector<StepReport>& reports) {
  SIGHTLINE_TRY(check_names(plan, options));
  ArtifactCache cache(options.cache_directory);
  std::vector<Scheduled> list = schedule(plan, wanted, options, artifacts, cache);
  check_inputs(plan, list, artifacts);
  Runner runner(plan, options, observer, artifacts, std::move(list), std::move(cache));
  SIGHTLINE_TRY(runner.check_may_run());
  SIGHTLINE_TRY(runner.check_cache());
  for (std::size_t i = 0; i < runner.list().size(); ++i) {
    const Scheduled& scheduled = runner.list()[i];
    const PassStep& step = runner.step_of(scheduled);
    if (observer.started) observer.started(i, runner.list().size(), step.name);
    Result<StepReport> report = Error{ErrorCode::kOutOfMemory, "not enough memory"};
    try {
      report = runner.run(scheduled);
    } catch (const std::bad_alloc&) {
      return named(report.error(), step.name);
    }
    if (!report) return report.error();
    reports.push_back(*report);
    if (observer.finished) observer.finished(*report);
    SIGHTLINE_TRY(print_if_asked(step, options, observer, artifacts));
  }
  return runner.make_wanted_whole();
}

}  // namespace sightline
