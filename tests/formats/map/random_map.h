#pragma once

#include <cstdint>

#include "formats/map/compiled_map.h"

namespace sightline {

struct RandomMapOptions {
  std::uint64_t seed = 1;
  int site_count = 40;
  int nd_count = 60;
  int run_count = 2;
  double tile_m = 64.0;
  double extent_m = 100.0;  // sites and NDs lie within this of the frame's origin
  std::vector<double> ranges_m = {10.0, 20.0, 50.0};
  std::vector<double> limits_m = {0.10, 0.25};
  // That take a sample; none: a map without.
  std::vector<Look> looks = {{.range_m = 100.0, .return_count = 650, .point_count = 40},
                             {.range_m = 80.0,
                              .return_count = 1944,
                              .even_beyond_m = 30.0,
                              .point_count = 80,
                              .is_by_normals = true,
                              .mode = LookMode::kSettle}};
  bool has_columns = false;  // two columns of sites: "clearance_m" and "kind"
  MapSize size = MapSize::kFull;
  std::size_t model_size = 300;  // bytes of a made-up model; 0: stripped
};

// A valid map whose numbers mean nothing: sites anywhere, NDs in random cells, random choices.
CompiledMap random_map(const RandomMapOptions& options);

}  // namespace sightline
