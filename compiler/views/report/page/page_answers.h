#pragma once

#include "compiler/views/report/page/packed.h"
#include "compiler/views/verdict/map_judgement.h"
#include "formats/map/compiled_map.h"

// What the map answers at each place, for the page (compiler/views/report/page/page_data.md).

namespace sightline {

// The kind of answer that the judgement recommends for each limit, and the answer at every site
// (recommended_answer()).
PageJson answers_json(const CompiledMap& map, const MapJudgement& judgement);

// The kind of place of each site and the bounds of a tracking vehicle's errors there; empty where
// the map has no kinds of place.
PageJson places_json(const CompiledMap& map);

}  // namespace sightline
