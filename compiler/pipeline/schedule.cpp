#include "compiler/pipeline/schedule.h"

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace sightline {
namespace {

// What the caller looks at, and what is to be printed or stopped after.
std::vector<AnyWire> all_wanted(const Plan& plan, const std::vector<AnyWire>& wanted,
                                const RunOptions& options) {
  std::vector<AnyWire> all = wanted;
  if (all.empty()) return plan.made();
  std::vector<std::string> names = options.print_after;
  if (!options.stop_after.empty()) names.push_back(options.stop_after);
  for (const std::string& name : names) {
    const auto step = std::ranges::find(plan.steps(), name, &PassStep::name);
    if (step != plan.steps().end()) all.push_back({step->output});
  }
  return all;
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

// On one line, and different for different texts.
std::string on_one_line(std::string_view text) {
  std::string line;
  for (const char c : text) {
    line += c == '\\' ? "\\\\" : c == '\n' ? "\\n" : std::string(1, c);
  }
  return line;
}

// Where inputs may be missing or repeated, how many each parameter of the pass has: a line, or
// nothing.
std::string counts_of_inputs(const PassStep& step) {
  const auto is_one = [](std::size_t count) { return count == 1; };
  if (std::ranges::all_of(step.input_counts, is_one)) return "";
  std::string line = "inputs by parameter =";
  for (const std::size_t count : step.input_counts) line += concat(" ", count);
  return line + "\n";
}

// Of how the step works and what its inputs hold. Their names are left out: equal contents give an
// equal output, whichever recording of a configuration they come from.
Digest digest_of(const Plan& plan, const PassStep& step, const Digest& way,
                 const std::function<Digest(std::size_t artifact)>& key_of_input) {
  DigestBuilder builder;
  builder.add(way);
  builder.add(counts_of_inputs(step));
  for (const std::size_t input : step.inputs) {
    builder.add(plan.artifact({input}).type->name);
    builder.add(key_of_input(input));
  }
  return builder.finish();
}

}  // namespace

std::vector<Scheduled> schedule(const Plan& plan, const std::vector<AnyWire>& wanted,
                                const RunOptions& options, const ArtifactSet& artifacts,
                                const ArtifactCache& cache) {
  const std::vector<AnyWire> all = all_wanted(plan, wanted, options);
  std::map<std::size_t, Digest> key_of;
  const auto key_of_input = [&](std::size_t artifact) {
    const auto made = key_of.find(artifact);
    return made != key_of.end() ? made->second : artifacts.entry({artifact}).key;
  };
  std::vector<Scheduled> list;
  for (const std::size_t index :
       steps_for(plan, all, [&](AnyWire wire) { return artifacts.has(wire); })) {
    const PassStep& step = plan.steps()[index];
    Scheduled next{index, step_key(plan, step, options.seed, key_of_input)};
    next.is_kept = can_be_kept(plan, step);
    next.is_stored = next.is_kept && cache.has(step.name, next.key.key);
    next.is_wanted = std::ranges::find(all, AnyWire{step.output}) != all.end();
    key_of[step.output] = next.key.key;
    list.push_back(std::move(next));
    if (step.name == options.stop_after) break;
  }
  std::set<std::size_t> needed;
  for (std::size_t i = list.size(); i-- > 0;) {
    const PassStep& step = plan.steps()[list[i].step];
    list[i].is_needed = list[i].is_wanted || needed.contains(step.output);
    // What is loaded takes its inputs only where part of it lies in them.
    if (list[i].runs() || (list[i].is_needed && step.reattach)) {
      needed.insert(step.inputs.begin(), step.inputs.end());
    }
  }
  return list;
}

std::vector<PlannedRun> planned_runs(const Plan& plan, const std::vector<AnyWire>& wanted,
                                     const RunOptions& options, const ArtifactSet& artifacts) {
  const ArtifactCache cache = ArtifactCache::to_look_at(options.cache_directory);
  std::vector<PlannedRun> runs;
  for (const Scheduled& scheduled : schedule(plan, wanted, options, artifacts, cache)) {
    runs.push_back({scheduled.step, plan.steps()[scheduled.step].name, !scheduled.runs(),
                    scheduled.is_kept, scheduled.key.key});
  }
  return runs;
}

StepKey step_key(const Plan& plan, const PassStep& step, std::uint64_t seed,
                 const std::function<Digest(std::size_t artifact)>& key_of_input) {
  const ArtifactType& output = *plan.artifact({step.output}).type;
  StepKey key;
  key.record = concat("pass version = ", step.version, "\n");
  key.record += concat("encoding version of ", output.name, " = ", output.version, "\n");
  key.record += concat("seed = ", seed, "\n");
  for (const auto& [name, value] : step.options) {
    key.record += concat("option ", name, " = ", on_one_line(value), "\n");
  }
  DigestBuilder way;
  way.add(pass_of(step));
  way.add(std::string_view(key.record));
  key.way = way.finish();
  for (const std::size_t input : step.inputs) {
    key.record +=
        concat("input ", plan.artifact({input}).name, " = ", to_hex(key_of_input(input)), "\n");
  }
  key.record += counts_of_inputs(step);
  key.key = digest_of(plan, step, key.way, key_of_input);
  return key;
}

Digest part_key(const StepKey& step, const PartName& part) {
  DigestBuilder builder;
  if (part.content) {
    builder.add("part of content");
    builder.add(step.way);
    builder.add(*part.content);
  } else {
    builder.add("part of number");
    builder.add(step.key);
    builder.add(std::to_string(part.number));
  }
  return builder.finish();
}

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
      reason += concat(name, " was ", was->substr(name.size() + 3), ", is ",
                       line.substr(name.size() + 3));
    }
  }
  return reason.empty() ? "its result is no longer in the cache" : reason;
}

}  // namespace sightline
