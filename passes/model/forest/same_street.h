#pragma once

#include "formats/annotation/driven_places.h"
#include "passes/model/forest/folds.h"

// Which driven places are one ("Identity of recordings" in schemas/definitions.md).

namespace sightline {

// How well the best stretch of two routes agrees, forwards or backwards, whatever their axes: of a
// fifth of the shorter route, and 60 m at least, the median over factors and looks of the
// correlation of their details (each without its mean within 15 m). 0 where the shorter one has
// not 60 m, or ranges, factors or the distance of sites differ.
double street_likeness(const DrivenPlace& a, const DrivenPlace& b);

inline constexpr double kLeastStretch_m = 60.0;  // shorter ones agree by chance
// tests/bench/README.md, "Identity of recordings and places".
inline constexpr double kOneStreet = 0.82;

// Whether more than a fifth of the shorter of two routes is within 20 m of the other one, if both
// are in world coordinates; else whether their likeness is at least kOneStreet.
bool is_one_street(const DrivenPlace& a, const DrivenPlace& b);

// Places that share a recording or are one street have one number.
Origins origins_of(const DrivenPlaces& places);

}  // namespace sightline
