#pragma once

#include <string>
#include <vector>

#include "passes/pass/options.h"

namespace sightline {

struct ChooseFieldSitesOptions {
  double spacing_m = 2.0;
  double width_m = 2.0;     // of a vehicle
  double height_m = 2.0;    // of it, above ground
  std::string from;         // "x, y" in world coordinates, m; empty: the largest stretch
  std::string within;       // "x0, y0, x1, y1" in world coordinates, m; empty: the whole map
  double memory_gib = 2.0;  // that annotating the places may take
  int most_places = 0;      // 0: as many as that memory holds
};
std::vector<OptionField> option_fields(ChooseFieldSitesOptions& options);

}  // namespace sightline
