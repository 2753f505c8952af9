#pragma once

#include "tests/compiler/views/report/sources.h"

namespace sightline {

// All that a report may know of a made-up straight road along x: a site a metre, and NDs, surface
// and depth images about as many and as varied as a compiled town has for each metre.
MadeSources long_road(int metres);

}  // namespace sightline
