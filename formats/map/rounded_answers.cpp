#include "formats/map/rounded_answers.h"

#include <algorithm>
#include <cmath>

#include "formats/reader/map_layout.h"

namespace sightline {
namespace {

double to_multiple(double value, double unit) { return std::round(value / unit) * unit; }

void round_site(Site& site) {
  site.s_m = to_multiple(site.s_m, kSmallLength_m);
  for (int axis = 0; axis < 3; ++axis) {
    site.p_map_m[axis] = to_multiple(site.p_map_m[axis], kSmallLength_m);
    double& place_m = site.T_map_vehicle(axis, 3);
    place_m = to_multiple(place_m, kSmallLength_m);
    for (int column = 0; column < 3; ++column) {
      double& entry = site.T_map_vehicle(axis, column);
      entry = to_multiple(entry, kSmallRotation);
    }
  }
}

void round_predicted(PredictedError& predicted) {
  for (double& mean_m : predicted.mean_m) {
    mean_m = std::min(to_multiple(mean_m, kSmallLength_m), kLongestSmallError_m);
  }
  for (double& share : predicted.within_probability) share = to_multiple(share, kSmallShare);
}

}  // namespace

void round_answers(CompiledMap& map) {
  for (Site& site : map.sites.sites) round_site(site);
  round_predicted(map.predicted);
  if (map.looks) round_predicted(map.looks->predicted);
}

}  // namespace sightline
