#pragma once

#include <vector>

#include "formats/annotation/sites.h"

namespace sightline {

// How far each site lies from the first, with all runs laid end to end, one spacing apart.
std::vector<double> route_of_sites_m(const Sites& sites);

}  // namespace sightline
