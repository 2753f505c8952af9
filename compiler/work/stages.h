#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "compiler/pipeline/plan.h"

namespace sightline {

// The work of a compile, cut where all of it before must be finished: within a stage any number of
// processes may be at work. kLink is what is left at the end, for one process.
enum class Stage { kDrives, kGraph, kTiles, kSites, kLearn, kLink };

inline constexpr std::array kWorkStages = {Stage::kDrives, Stage::kGraph, Stage::kTiles,
                                           Stage::kSites, Stage::kLearn};

std::string_view stage_name(Stage stage);  // "drives", "graph", ...
std::optional<Stage> stage_named(std::string_view name);

// Whether it is more than one unit of work.
bool is_shared(Stage stage);

// Of a step of a compile. No step takes what a later stage makes. A pass that is not known here is
// our own mistake.
Stage stage_of(const PassStep& step);

}  // namespace sightline
