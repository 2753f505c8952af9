/* How far to look at one place, from C:  vehicle_reader_c MAP LIMIT_M X_M Y_M Z_M [LOCALIZER] */
#include <stdio.h>
#include <stdlib.h>

#include "formats/reader/sightline_reader.h"

int main(int argc, char** argv) {
  if (argc != 6 && argc != 7) {
    fprintf(stderr, "usage: %s MAP LIMIT_M X_M Y_M Z_M [LOCALIZER]\n", argv[0]);
    return 64;
  }
  sightline_map* map = NULL;
  char message[512];
  const char* localizer = argc == 7 ? argv[6] : "searching";
  if (sightline_open(argv[1], localizer, &map, message, sizeof message) != 0) {
    fprintf(stderr, "%s\n", message);
    return 1;
  }
  const double position_world_m[3] = {atof(argv[3]), atof(argv[4]), atof(argv[5])};
  sightline_range range;
  const int error = sightline_observation_range(map, position_world_m, atof(argv[2]), &range);
  if (error != 0) fprintf(stderr, "SL%d %s\n", error, sightline_error_name(error));
  if (range.flags & SIGHTLINE_UNKNOWN_LOCALIZER) {
    printf("look %g m: errors of localizer %s are unknown\n", range.range_m, localizer);
    sightline_close(map);
    return error == 0 ? 0 : 1;
  }
  printf("look %g m, within the limit with probability %g\n", range.range_m, range.probability);
  sightline_close(map);
  return error == 0 ? 0 : 1;
}
