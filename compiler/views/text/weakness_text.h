#pragma once

#include <string>

#include "formats/text/table.h"
#include "passes/weakness/find_weakness.h"

namespace sightline {

// For people: a line for each stretch, then its cause in a sentence and the places where a board
// would help. Positions in world coordinates, m.
std::string to_text(const Weakness& weakness, const Sites& sites);

// "Along the road 4 of 132 upright surfaces in sight hold the vehicle, the nearest 31 m away." and
// what makes of that the cause.
std::string cause_sentence(const ExplainedStretch& stretch);

// "no stretch": the weak share of the route in a sentence, with what counts as weak.
std::string summary_sentence(const Weakness& weakness);

// A row for each stretch, with the best place for a board; positions in world coordinates, m.
Table table_of(const Weakness& weakness, const Sites& sites);

}  // namespace sightline
