#pragma once

#include <cstdint>
#include <string>

#include "formats/base/result.h"
#include "formats/map/compiled_map.h"
#include "passes/pass/pass_context.h"

namespace sightline {

// What a map's annotation was proven by.
struct AnnotationProof {
  std::uint32_t site_count = 0;
  // Sites whose predictions the forest makes again from the stored factors.
  std::uint32_t forest_count = 0;
  // Sites that trained the model: theirs equal the predictions that the model keeps of the very
  // same place and factors. The trees that made those, which never saw the place, are not kept.
  std::uint32_t out_of_fold_count = 0;
  std::uint32_t history_count = 0;  // sites whose features hold what an earlier drive measured
};

// Makes every prediction, promise, choice, flag and count of a map's annotation again, from its
// factors and its forest, and demands the same numbers, bit for bit. What a drive measured (the
// factors' columns measured_*, and a quality's measured_coverage) is taken as stored. Errors:
// bad-layer where the map was stripped of factors or model; digest-mismatch, naming the first
// site or limit that does not follow; those of model_of, predict_error and choose_ranges.
Result<AnnotationProof> prove_annotation(PassContext& ctx, const CompiledMap& map);

// One paragraph for people.
std::string to_text(const AnnotationProof& proof);

}  // namespace sightline
