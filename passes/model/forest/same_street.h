#pragma once

#include "formats/annotation/driven_places.h"
#include "passes/model/forest/folds.h"

// Which driven places are one ("Identity of recordings" in schemas/definitions.md).

namespace sightline {

// Whether more than a fifth of the shorter of two routes is within 20 m of the other one, and what
// is seen there agrees: both are in world coordinates, or the median over factors of the
// correlation between neighbouring sites, at the longest range, is 0.9 or more over 40 m at least.
// Recordings without coordinates of their own all begin near 0.
bool is_one_street(const DrivenPlace& a, const DrivenPlace& b);

// Places that share a recording or are one street have one number.
Origins origins_of(const DrivenPlaces& places);

}  // namespace sightline
