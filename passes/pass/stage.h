#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

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

}  // namespace sightline
