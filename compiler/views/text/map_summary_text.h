#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "compiler/views/verdict/verdict.h"
#include "formats/map/map_reader.h"

// A map on one screen: what `sightline inspect` prints, and `compile` as JSON.

namespace sightline {

// "601 places, 600 m of route"
std::string extent_text(const Sites& sites);

// A map that was read from a file, which may lack its NDs.
struct InspectedMap {
  std::filesystem::path file;
  const CompiledMap& map;
  const MapSummary& summary;
  const MapJudgement& judgement;
  const EvaluationFigures* evaluation = nullptr;  // null: none
};

// At most 40 lines of at most 120 columns, as far as names of files allow; begins with the verdict.
std::string summary_text(const InspectedMap& inspected);

// schemas/inspect.schema.json
nlohmann::ordered_json to_json(const InspectedMap& inspected);

// Of a model, as the same schema has it.
nlohmann::ordered_json model_json(const ByFamily<ErrorModel>& model);

// What the drive of an evaluation found: plan, look and range of the map beside the best constant
// answer, for each of the first four limits. At most seven lines.
std::string answers_table(const EvaluationFigures& evaluation, const MapJudgement& judgement);

}  // namespace sightline
