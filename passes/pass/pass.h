#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "formats/base/result.h"
#include "passes/pass/options.h"
#include "passes/pass/pass_context.h"

namespace sightline {

// The work of a compile in parts that follow each other: all steps of one stage are finished before
// the next stage begins, and within a stage any number of processes may work. kLink is what is left
// at the end, for one process.
enum class Stage { kDrives, kGraph, kTiles, kSites, kLearn, kLink };

inline constexpr std::array kWorkStages = {Stage::kDrives, Stage::kGraph, Stage::kTiles,
                                           Stage::kSites, Stage::kLearn};

// By the number of the stage.
inline constexpr std::array<std::string_view, 6> kStageNames = {"drives", "graph", "tiles",
                                                                "sites",  "learn", "link"};

constexpr std::string_view stage_name(Stage stage) {
  return kStageNames[static_cast<std::size_t>(stage)];
}

constexpr std::optional<Stage> stage_named(std::string_view name) {
  const auto found = std::ranges::find(kStageNames, name);
  if (found == kStageNames.end()) return std::nullopt;
  return static_cast<Stage>(found - kStageNames.begin());
}

// Whether it is more than one unit of work.
constexpr bool is_shared(Stage stage) {
  return stage == Stage::kDrives || stage == Stage::kTiles || stage == Stage::kSites;
}

// Any number of inputs of one type, in the order in which the plan names them.
template <class X>
using Many = std::span<const X* const>;

// How long a pass takes, about: seconds of one core by --time-passes, good to a factor of two.
struct Cost {
  double scan_s = 0.0;            // for each scan of the step's drive
  double million_points_s = 0.0;  // for each million of its points
  double without_poses_s = 0.0;   // beside that, for each million of points without given poses
};

// A pass describes itself once, beside its function:
//
//   Result<TiledNds> build_ndt(PassContext& ctx, const BuildNdtOptions& options,
//                              const SurfacePoints& points);
//   inline constexpr Pass kBuildNdt =
//       Pass{"build-ndt", 1, "nds", "The NDT map", &build_ndt}.in(Stage::kTiles);
//
// Its inputs, its options and its output are read off the signature: `const X&` is an input that
// the pass needs, `const X*` one that may be missing (null), `Many<X>` a list of any length. The
// section of the configuration, the published schema, the cache key, `--stop-after` and
// `dump --what` follow.
template <class Output, class Options, class... Parameters>
struct Pass {
  std::string_view name;   // "build-ndt": of the step, and of the section with its options
  std::uint32_t version;   // raised in the commit after which equal inputs give other bytes
  std::string_view table;  // what `dump --what` calls the output: "nds"
  std::string_view help;   // one line above the section of the configuration
  Result<Output> (*run)(PassContext&, const Options&, Parameters...);
  // The first stage in which it may run. It never runs in an earlier one than what makes its
  // inputs: a pass that names no stage runs in theirs.
  Stage stage = Stage::kDrives;
  Cost cost = {};  // for estimates before a run; none: too little to count

  [[nodiscard]] constexpr Pass in(Stage other_stage) const {
    Pass pass = *this;
    pass.stage = other_stage;
    return pass;
  }
  [[nodiscard]] constexpr Pass with(const Cost& other_cost) const {
    Pass pass = *this;
    pass.cost = other_cost;
    return pass;
  }
};

template <class Output, class Options, class... Parameters>
Pass(std::string_view, std::uint32_t, std::string_view, std::string_view,
     Result<Output> (*)(PassContext&, const Options&, Parameters...))
    -> Pass<Output, Options, Parameters...>;

// The same pass on other inputs: all but the function are those of `pass`.
template <class Output, class Options, class... Parameters, class... OtherParameters>
constexpr Pass<Output, Options, OtherParameters...> variant_of(
    const Pass<Output, Options, Parameters...>& pass,
    Result<Output> (*run)(PassContext&, const Options&, OtherParameters...)) {
  return {pass.name, pass.version, pass.table, pass.help, run, pass.stage, pass.cost};
}

// The options of a pass that has none.
struct NoOptions {};
inline std::vector<OptionField> option_fields(NoOptions&) { return {}; }

}  // namespace sightline
