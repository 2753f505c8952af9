#pragma once

#include <cstddef>
#include <string>

#include "formats/model/error_model.h"

namespace sightline {

// How many of the places of a card are different streets. One of an earlier program, which does not
// list whose recordings have scans in common, counts as another.
std::size_t place_count(const TrainingCard& card);

// "2 places"; "1 place (copy.yaml is the same place as drive.yaml)"
std::string places_text(const TrainingCard& card);

// The earlier place of a card that place `i` is; empty: none.
std::string same_place(const TrainingCard& card, std::size_t i);

}  // namespace sightline
