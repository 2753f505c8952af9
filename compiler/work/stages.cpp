#include "compiler/work/stages.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "formats/base/check.h"

namespace sightline {
namespace {

constexpr std::array<std::pair<Stage, std::string_view>, 6> kNames = {{{Stage::kDrives, "drives"},
                                                                       {Stage::kGraph, "graph"},
                                                                       {Stage::kTiles, "tiles"},
                                                                       {Stage::kSites, "sites"},
                                                                       {Stage::kLearn, "learn"},
                                                                       {Stage::kLink, "link"}}};

// By pass. A pass that runs for a drive beside the one that makes the map has a label; one that
// runs elsewhere with a label of its own is named with it.
struct PassStage {
  std::string_view pass;
  Stage stage;
  Stage with_label;
};

constexpr std::array kStages = {
    PassStage{"ingest", Stage::kDrives, Stage::kDrives},
    PassStage{"ingest-map", Stage::kDrives, Stage::kDrives},
    PassStage{"ingest-compiled-map", Stage::kDrives, Stage::kDrives},
    PassStage{"ingest-nd-map", Stage::kDrives, Stage::kDrives},
    PassStage{"join-drives", Stage::kGraph, Stage::kGraph},
    PassStage{"join-sensors", Stage::kGraph, Stage::kGraph},
    PassStage{"estimate-trajectory", Stage::kGraph, Stage::kDrives},
    PassStage{"choose-scans", Stage::kTiles, Stage::kTiles},
    PassStage{"release-poses", Stage::kTiles, Stage::kTiles},
    PassStage{"complete-trajectory", Stage::kTiles, Stage::kTiles},
    PassStage{"released-drive", Stage::kGraph, Stage::kGraph},
    PassStage{"released-trajectory", Stage::kGraph, Stage::kGraph},
    PassStage{"undistort-scans:released", Stage::kGraph, Stage::kGraph},
    PassStage{"undistort-scans", Stage::kTiles, Stage::kTiles},
    PassStage{"remove-moving", Stage::kTiles, Stage::kTiles},
    PassStage{"count-drives", Stage::kTiles, Stage::kTiles},
    PassStage{"build-ndt", Stage::kTiles, Stage::kTiles},
    PassStage{"pack-nds", Stage::kTiles, Stage::kTiles},
    PassStage{"build-surface", Stage::kTiles, Stage::kTiles},
    PassStage{"measure-sharpness", Stage::kTiles, Stage::kTiles},
    PassStage{"choose-sites", Stage::kTiles, Stage::kTiles},
    PassStage{"choose-route-sites", Stage::kTiles, Stage::kTiles},
    PassStage{"build-nd-surface", Stage::kTiles, Stage::kTiles},
    PassStage{"choose-field-sites", Stage::kTiles, Stage::kTiles},
    PassStage{"align-drive", Stage::kTiles, Stage::kTiles},
    PassStage{"cast-rays", Stage::kSites, Stage::kSites},
    PassStage{"cast-scans", Stage::kSites, Stage::kSites},
    PassStage{"compute-factors", Stage::kSites, Stage::kSites},
    PassStage{"simulate-error", Stage::kSites, Stage::kSites},
    PassStage{"measure-error", Stage::kSites, Stage::kSites},
    PassStage{"import-errors", Stage::kSites, Stage::kSites},
    PassStage{"add-mapping-error", Stage::kSites, Stage::kSites},
    PassStage{"join-errors", Stage::kLearn, Stage::kLearn},
    PassStage{"pool-errors", Stage::kLearn, Stage::kLearn},
    PassStage{"history-of-map", Stage::kLearn, Stage::kLearn},
    PassStage{"train-model", Stage::kLearn, Stage::kLearn},
    PassStage{"predict-error", Stage::kLearn, Stage::kLearn},
    PassStage{"add-history", Stage::kLearn, Stage::kLearn},
    PassStage{"choose-ranges", Stage::kLearn, Stage::kLearn},
    PassStage{"evaluate-ranges", Stage::kLearn, Stage::kLearn},
    PassStage{"calibrate-plan", Stage::kLearn, Stage::kLearn},
    PassStage{"pack-model", Stage::kLearn, Stage::kLearn},
    PassStage{"emit-map", Stage::kLink, Stage::kLink},
};

}  // namespace

std::string_view stage_name(Stage stage) { return kNames[static_cast<std::size_t>(stage)].second; }

std::optional<Stage> stage_named(std::string_view name) {
  for (const auto& [stage, known] : kNames) {
    if (known == name) return stage;
  }
  return std::nullopt;
}

bool is_shared(Stage stage) {
  return stage == Stage::kDrives || stage == Stage::kTiles || stage == Stage::kSites;
}

Stage stage_of(const PassStep& step) {
  const std::size_t colon = step.name.find(':');
  auto found = std::ranges::find(kStages, step.name, &PassStage::pass);
  if (found == kStages.end()) {
    found =
        std::ranges::find(kStages, std::string_view(step.name).substr(0, colon), &PassStage::pass);
  }
  SIGHTLINE_CHECK(found != kStages.end());
  return colon == std::string::npos ? found->stage : found->with_label;
}

}  // namespace sightline
