#include "tests/formats/reader/c_interface.h"

#include <stdlib.h>

int range_from_c(const char* path, const double position_world_m[3], double limit_m,
                 sightline_range* range) {
  sightline_map* map = NULL;
  sightline_info info;
  const int opened = sightline_open(path, "annealed", &map, NULL, 0);
  if (opened != 0) return opened;
  sightline_get_info(map, &info);
  const int found = sightline_observation_range(map, position_world_m, limit_m, range);
  if (found == 0 && range->range_m > info.ranges_m[info.range_count - 1]) abort();
  sightline_close(map);
  return found;
}
