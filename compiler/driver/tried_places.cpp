#include "compiler/driver/tried_places.h"

#include <algorithm>
#include <array>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "compiler/pipeline/process_cost.h"
#include "compiler/pipeline/runner.h"
#include "compiler/pipeline/schedule.h"
#include "formats/base/evenly.h"
#include "passes/rays/site_blocks.h"

// What a pass takes for some places is a part for the whole map, one for each block of places, and
// one for each place. Three trials tell them apart: few places of one block, few of each of several
// blocks, many of these.

namespace sightline {
namespace {

constexpr std::array<std::string_view, 2> kDearPasses = {"compute-factors", "simulate-error"};
// All other passes, for each place.
constexpr double kOthers_s = 0.0005;
constexpr std::size_t kBlocks = 6;
constexpr std::size_t kFew = 4;  // of a block
constexpr std::size_t kMany = 32;

// Those that hold sites which lie evenly among all, each once.
std::vector<SiteBlock> some_blocks(const Sites& sites) {
  std::vector<SiteBlock> some;
  for (SiteBlock& block : blocks_of_sites(sites)) {
    for (std::size_t i = 0; i < kBlocks; ++i) {
      const std::size_t site = (2 * i + 1) * sites.sites.size() / (2 * kBlocks);
      if (!std::ranges::binary_search(block.sites, site)) continue;
      some.push_back(std::move(block));
      break;
    }
  }
  return some;
}

// At most so many of each block, evenly among its own.
Sites some_sites(const Sites& all, std::span<const SiteBlock> blocks, std::size_t most) {
  std::vector<std::size_t> chosen;
  for (const SiteBlock& block : blocks) {
    for (const std::size_t i : evenly(block.sites.size(), most)) chosen.push_back(block.sites[i]);
  }
  std::ranges::sort(chosen);
  Sites some;
  some.frame = all.frame;
  some.spacing_m = all.spacing_m;
  for (const std::size_t site : chosen) some.sites.push_back(all.sites[site]);
  return some;
}

// Seconds of one core that the dear passes take for these places.
Result<double> cpu_of(const CompilePlan& compile, const RunOptions& options,
                      const ArtifactSet& artifacts, const Sites& some) {
  const std::shared_ptr<const void> sites = std::make_shared<const Sites>(some);
  double cpu_s = 0.0;
  for (const PassStep& step : compile.plan.steps()) {
    if (std::ranges::find(kDearPasses, step.name) == kDearPasses.end()) continue;
    std::vector<std::shared_ptr<const void>> inputs;
    for (std::size_t i = 0; i < step.inputs.size(); ++i) {
      const AnyWire input{step.inputs[i]};
      ArtifactSet::Entry entry = artifacts.entry(input);
      if (input == compile.sites.any()) entry.value = sites;
      SIGHTLINE_ASSIGN(std::shared_ptr<const void> taken, in_form(entry, *step.input_types[i]));
      inputs.push_back(std::move(taken));
    }
    PassContext ctx;
    ctx.seed = options.seed;
    const double begin_s = process_cpu_s();
    SIGHTLINE_TRY(step.run(ctx, inputs));
    cpu_s += process_cpu_s() - begin_s;
  }
  return cpu_s;
}

// Whether all that is dear of what is tried on is there, and what it is for is not.
bool can_try(const CompilePlan& compile, const RunOptions& options, const ArtifactSet& artifacts) {
  if (!compile.simulated.is_connected()) return false;
  const auto is_there = [&](AnyWire wire) {
    const std::vector<PlannedRun> runs = planned_runs(compile.plan, {wire}, options, artifacts);
    return !runs.empty() && runs.back().is_in_cache;
  };
  return is_there(compile.sites) && is_there(compile.surface) && !is_there(compile.simulated);
}

}  // namespace

Result<std::optional<ExpectedPlaces>> try_places(const CompilePlan& compile,
                                                 const RunOptions& options, ArtifactSet artifacts) {
  if (!can_try(compile, options, artifacts)) return std::optional<ExpectedPlaces>();
  std::vector<StepReport> reports;
  SIGHTLINE_TRY(run_plan(compile.plan, {compile.ndt, compile.surface, compile.sites}, options, {},
                         artifacts, reports));
  const Sites& sites = artifacts.get(compile.sites);
  const std::vector<SiteBlock> blocks = some_blocks(sites);
  const Sites few_of_one = some_sites(sites, std::span(blocks).first(1), kFew);
  const Sites few = some_sites(sites, blocks, kFew);
  const Sites many = some_sites(sites, blocks, kMany);
  SIGHTLINE_ASSIGN(const double one_s, cpu_of(compile, options, artifacts, few_of_one));
  SIGHTLINE_ASSIGN(const double few_s, cpu_of(compile, options, artifacts, few));
  SIGHTLINE_ASSIGN(const double many_s, cpu_of(compile, options, artifacts, many));
  const auto count_of = [](const Sites& of) { return static_cast<double>(of.sites.size()); };
  const double more = count_of(many) - count_of(few);
  const double place_s = more > 0.0 ? std::max(0.0, (many_s - few_s) / more) : 0.0;
  const double more_blocks = static_cast<double>(blocks.size()) - 1.0;
  const double of_blocks_s = few_s - one_s - place_s * (count_of(few) - count_of(few_of_one));
  const double block_s = more_blocks > 0.0 ? std::max(0.0, of_blocks_s / more_blocks) : 0.0;
  ExpectedPlaces places{sites.sites.size(), many.sites.size(), many_s};
  places.cpu_s += (place_s + kOthers_s) * (count_of(sites) - count_of(many));
  places.cpu_s += block_s * static_cast<double>(blocks_of_sites(sites).size() - blocks.size());
  return std::optional(places);
}

}  // namespace sightline
