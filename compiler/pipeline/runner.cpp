#include "compiler/pipeline/runner.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <mutex>
#include <new>
#include <set>

#include "compiler/store/cache.h"

namespace sightline {
namespace {

struct Stamp {
  std::chrono::steady_clock::time_point wall = std::chrono::steady_clock::now();
  double cpu_s = 0.0;
};

double process_cpu_s() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

// Linux keeps the peak since the process began; writing 5 here starts it anew. Where that is not
// allowed the peak is that of the whole run so far.
void reset_peak_memory() { std::ofstream("/proc/self/clear_refs") << "5"; }

double peak_memory_mib() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) return std::stod(line.substr(6)) / 1024.0;
  }
  return 0.0;
}

// All that decides a step's output, as lines that a person can compare.
std::string key_record(const Plan& plan, const PassStep& step, const RunOptions& options,
                       const ArtifactSet& artifacts) {
  const ArtifactType& output = *plan.artifact({step.output}).type;
  std::string record = "pass version = " + std::to_string(step.version) + "\n";
  record += "encoding version of " + std::string(output.name) + " = " +
            std::to_string(output.version) + "\n";
  record += "seed = " + std::to_string(options.seed) + "\n";
  for (const auto& [name, value] : step.options) record += "option " + name + " = " + value + "\n";
  for (const std::size_t input : step.inputs) {
    record += "input " + plan.artifact({input}).name + " = " +
              to_hex(artifacts.entry({input}).key) + "\n";
  }
  return record;
}

Digest key_of(const PassStep& step, const std::string& record) {
  DigestBuilder builder;
  builder.add(std::string_view(step.name));
  builder.add(std::string_view(record));
  return builder.finish();
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    lines.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return lines;
}

// Why a step must run: the first lines in which its record differs from that of the last run.
std::string reason_to_run(const std::string& before, const std::string& now) {
  if (before.empty()) return "never ran here";
  const std::vector<std::string> old_lines = lines_of(before);
  std::string reason;
  for (const std::string& line : lines_of(now)) {
    if (std::ranges::find(old_lines, line) != old_lines.end()) continue;
    const std::string name = line.substr(0, line.find(" = "));
    const auto was = std::ranges::find_if(
        old_lines, [&](const std::string& old_line) { return old_line.starts_with(name + " = "); });
    if (!reason.empty()) reason += "; ";
    if (name.starts_with("input ")) {
      reason += name + " changed";
    } else if (was == old_lines.end()) {
      reason += "new: " + line;
    } else {
      reason +=
          name + " was " + was->substr(name.size() + 3) + ", is " + line.substr(name.size() + 3);
    }
  }
  return reason.empty() ? "its result is not in the cache any more" : reason;
}

Error named(Error error, const std::string& pass) {
  if (error.place.empty())
    error.place = "pass " + pass;
  else
    error.message += " [pass " + pass + "]";
  return error;
}

class Runner {
 public:
  Runner(const Plan& plan, const RunOptions& options, const RunObserver& observer,
         ArtifactSet& artifacts)
      : plan_(plan),
        options_(options),
        observer_(observer),
        artifacts_(artifacts),
        cache_(options.cache_directory) {}

  Result<StepReport> run(const PassStep& step) {
    StepReport report;
    report.name = step.name;
    const Stamp begin{.cpu_s = process_cpu_s()};
    reset_peak_memory();
    const std::string record = key_record(plan_, step, options_, artifacts_);
    const Digest key = key_of(step, record);
    std::shared_ptr<const void> output = from_cache(step, key, report);
    report.from_cache = output != nullptr;
    report.reason = output ? "unchanged" : reason_to_run(cache_.last_record(step.name), record);
    if (!output) {
      Result<std::shared_ptr<const void>> made = make(step, key, report);
      if (!made) return named(made.error(), step.name);
      output = *made;
    }
    SIGHTLINE_TRY(cache_.store_record(step.name, record));
    artifacts_.put({step.output}, {&output_type(step), output, key});
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin.wall;
    report.wall_s = wall.count();
    report.cpu_s = process_cpu_s() - begin.cpu_s;
    report.peak_memory_mib = peak_memory_mib();
    return report;
  }

 private:
  [[nodiscard]] const ArtifactType& output_type(const PassStep& step) const {
    return *plan_.artifact({step.output}).type;
  }

  std::vector<std::shared_ptr<const void>> inputs_of(const PassStep& step) const {
    std::vector<std::shared_ptr<const void>> inputs;
    for (const std::size_t input : step.inputs) inputs.push_back(artifacts_.entry({input}).value);
    return inputs;
  }

  std::shared_ptr<const void> from_cache(const PassStep& step, const Digest& key,
                                         StepReport& report) const {
    if (!output_type(step).read) return nullptr;
    const Result<ArtifactCache::Content> found = cache_.load(step.name, key);
    if (!found) return refuse(step, report, found.error());
    if (!*found) return nullptr;
    Result<std::shared_ptr<const void>> artifact = output_type(step).read(**found);
    if (!artifact) return refuse(step, report, artifact.error());
    if (step.reattach) return step.reattach(*artifact, inputs_of(step));
    return *artifact;
  }

  std::shared_ptr<const void> refuse(const PassStep& step, StepReport& report,
                                     const Error& error) const {
    note(step, report, "a cache file is not used, its content is made anew: " + to_string(error));
    return nullptr;
  }

  Result<std::shared_ptr<const void>> make(const PassStep& step, const Digest& key,
                                           StepReport& report) const {
    const std::vector<std::shared_ptr<const void>> inputs = inputs_of(step);
    PassContext ctx;
    ctx.threads = options_.threads;
    ctx.seed = options_.seed;
    ctx.progress_sink = observer_.progress;
    std::mutex mutex;
    ctx.saved_part = [&](std::size_t part) -> ArtifactCache::Content {
      Result<ArtifactCache::Content> found = cache_.load_part(step.name, key, part);
      if (found) return std::move(*found);
      const std::lock_guard<std::mutex> lock(mutex);
      refuse(step, report, found.error());
      return std::nullopt;
    };
    ctx.part_sink = [&](std::size_t part, std::span<const std::byte> bytes) {
      cache_.store_part(step.name, key, part, bytes);
    };
    ctx.warning_sink = [&](const std::string& message) {
      const std::lock_guard<std::mutex> lock(mutex);
      note(step, report, message);
    };
    SIGHTLINE_ASSIGN(std::shared_ptr<const void> output, step.run(ctx, inputs));
    SIGHTLINE_TRY(output_type(step).check(output.get()));
    if (cache_.is_enabled() && output_type(step).write) {
      SIGHTLINE_TRY(cache_.store(step.name, key, output_type(step).write(output.get())));
      cache_.remove_parts(step.name, key);
    }
    return output;
  }

  void note(const PassStep& step, StepReport& report, const std::string& message) const {
    report.warnings.push_back(message);
    if (observer_.warning) observer_.warning(step.name, message);
  }

  const Plan& plan_;
  const RunOptions& options_;
  const RunObserver& observer_;
  ArtifactSet& artifacts_;
  ArtifactCache cache_;
};

Result<void> check_names(const Plan& plan, const RunOptions& options) {
  std::vector<std::string> known;
  for (const PassStep& step : plan.steps()) known.push_back(step.name);
  std::vector<std::string> asked = options.print_after;
  if (!options.stop_after.empty()) asked.push_back(options.stop_after);
  for (const std::string& name : asked) {
    if (std::ranges::find(known, name) != known.end()) continue;
    const std::string near = nearest_name(name, known);
    return Error{
        ErrorCode::kUnknownPass,
        "no pass is called '" + name + "'" +
            (near.empty() ? "; 'sightline passes' lists them" : "; did you mean " + near + "?"),
        "", ""};
  }
  return {};
}

// A plan that is run without what it takes from outside is our own mistake: found before hours of
// work, not after them.
void check_inputs(const Plan& plan, const std::vector<std::size_t>& steps,
                  const ArtifactSet& artifacts) {
  std::set<std::size_t> made;
  for (const std::size_t index : steps) {
    for (const std::size_t input : plan.steps()[index].inputs) {
      SIGHTLINE_CHECK(made.contains(input) || artifacts.has({input}));
    }
    made.insert(plan.steps()[index].output);
  }
}

void print_if_asked(const Plan& plan, const PassStep& step, const RunOptions& options,
                    const RunObserver& observer, const ArtifactSet& artifacts) {
  if (!observer.printed ||
      std::ranges::find(options.print_after, step.name) == options.print_after.end()) {
    return;
  }
  const AnyWire output{step.output};
  observer.printed(step.name,
                   plan.artifact(output).type->print(artifacts.entry(output).value.get()));
}

}  // namespace

std::vector<PlannedRun> planned_runs(const Plan& plan, const std::vector<AnyWire>& wanted,
                                     const RunOptions& options, const ArtifactSet& artifacts) {
  ArtifactSet known = artifacts;  // with the keys of what is not made yet
  const ArtifactCache cache = ArtifactCache::to_look_at(options.cache_directory);
  std::vector<PlannedRun> runs;
  for (const std::size_t index :
       steps_for(plan, wanted, [&](AnyWire wire) { return artifacts.has(wire); })) {
    const PassStep& step = plan.steps()[index];
    const Digest key = key_of(step, key_record(plan, step, options, known));
    const ArtifactType* type = plan.artifact({step.output}).type;
    known.put({step.output}, {type, nullptr, key});
    runs.push_back({step.name, type->read && cache.has(step.name, key)});
    if (step.name == options.stop_after) break;
  }
  return runs;
}

Result<void> run_plan(const Plan& plan, const std::vector<AnyWire>& wanted,
                      const RunOptions& options, const RunObserver& observer,
                      ArtifactSet& artifacts, std::vector<StepReport>& reports) {
  SIGHTLINE_TRY(check_names(plan, options));
  const std::vector<std::size_t> steps =
      steps_for(plan, wanted, [&](AnyWire wire) { return artifacts.has(wire); });
  check_inputs(plan, steps, artifacts);
  Runner runner(plan, options, observer, artifacts);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const PassStep& step = plan.steps()[steps[i]];
    if (observer.started) observer.started(i, steps.size(), step.name);
    Result<StepReport> report = Error{ErrorCode::kOutOfMemory, "not enough memory", "", ""};
    try {
      report = runner.run(step);
    } catch (const std::bad_alloc&) {
      return named(report.error(), step.name);
    }
    if (!report) return report.error();
    reports.push_back(*report);
    if (observer.finished) observer.finished(*report);
    print_if_asked(plan, step, options, observer, artifacts);
    if (step.name == options.stop_after) break;
  }
  return {};
}

}  // namespace sightline
