/* How far to look at one place, from C:  vehicle_reader_c MAP LIMIT_M X_M Y_M Z_M */
#include <stdio.h>
#include <stdlib.h>

#include "formats/reader/sightline_reader.h"

int main(int argc, char** argv) {
  if (argc != 6) {
    fprintf(stderr, "usage: %s MAP LIMIT_M X_M Y_M Z_M\n", argv[0]);
    return 64;
  }
  sightline_map* map = NULL;
  char message[512];
  if (sightline_open(argv[1], &map, message, sizeof message) != 0) {
    fprintf(stderr, "%s\n", message);
    return 1;
  }
  const double position_world_m[3] = {atof(argv[3]), atof(argv[4]), atof(argv[5])};
  sightline_range range;
  const int error = sightline_observation_range(map, position_world_m, atof(argv[2]), &range);
  if (error != 0) fprintf(stderr, "SL%d %s\n", error, sightline_error_name(error));
  printf("look %g m, within the limit with probability %g\n", range.range_m, range.probability);
  sightline_close(map);
  return error == 0 ? 0 : 1;
}
