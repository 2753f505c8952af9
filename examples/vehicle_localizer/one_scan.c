/* main.cpp from C:  vehicle_localizer_c MAP SCAN X_M Y_M Z_M YAW_DEG [LIMIT_M] */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "passes/vehicle/sightline_localizer.h"

/* A binary PCD of floats, x y z first; 0 where it is none. */
static float* read_scan(const char* path, sightline_points* points) {
  char line[256];
  size_t numbers_a_point = 0;
  float* numbers = NULL;
  FILE* file = fopen(path, "rb");
  memset(points, 0, sizeof *points);
  while (file != NULL && fgets(line, sizeof line, file) != NULL) {
    if (strncmp(line, "FIELDS ", 7) == 0) {
      for (const char* c = line + 6; *c != '\0'; ++c) numbers_a_point += *c == ' ';
    }
    if (strncmp(line, "POINTS ", 7) == 0) points->count = strtoul(line + 7, NULL, 10);
    if (strcmp(line, "DATA binary\n") != 0) continue;
    const size_t count = points->count * numbers_a_point;
    numbers = malloc(count * sizeof(float) + 1);
    if (numbers != NULL && fread(numbers, sizeof(float), count, file) == count) break;
    free(numbers);
    numbers = NULL;
  }
  if (file != NULL) fclose(file);
  points->first = numbers;
  points->stride_bytes = numbers_a_point * sizeof(float);
  return numbers;
}

static void print(const sightline_look* look, const sightline_match* match) {
  static const char* const stops[] = {"converged", "iteration limit", "no points", "no overlap"};
  const double* T = match->T_world_vehicle;
  const double* c = match->covariance;
  printf("range_m %g probability %.4f\n", look->range_m, look->probability);
  printf("stop %s\n", stops[match->stop]);
  printf("position_world_m %.17g %.17g %.17g\n", T[3], T[7], T[11]);
  printf("heading %.17g %.17g\n", T[0], T[4]);
  printf("score %.17g iterations %d points %u scored %u\n", match->score, match->iterations,
         match->point_count, match->scored_points);
  printf("variance_m2 %.17g %.17g %.17g weak %u\n", c[0], c[7], c[14], match->weak);
}

/* How far the map says to look there; 50 m where it is a point cloud. */
static int ask_look(const char* path, const char* localizer, const double* guess_m, double limit_m,
                    sightline_look* look) {
  const size_t length = strlen(path);
  sightline_map* map = NULL;
  memset(look, 0, sizeof *look);
  look->range_m = 50.0;
  if (length < 6 || strcmp(path + length - 6, ".slmap") != 0) return 0;
  int error = sightline_open(path, localizer, &map, NULL, 0);
  if (error == 0) error = sightline_get_look(map, guess_m, limit_m, INFINITY, look);
  sightline_close(map);
  return error;
}

int main(int argc, char** argv) {
  if (argc < 7 || argc > 8) {
    fprintf(stderr, "usage: %s MAP SCAN X_M Y_M Z_M YAW_DEG [LIMIT_M]\n", argv[0]);
    return 64;
  }
  sightline_localizer* localizer = NULL;
  sightline_localizer_info info;
  char message[512];
  if (sightline_localizer_open(argv[1], NULL, &localizer, message, sizeof message) != 0) {
    fprintf(stderr, "%s\n", message);
    return 1;
  }
  sightline_localizer_get_info(localizer, &info);
  const double guess_m[3] = {atof(argv[3]), atof(argv[4]), atof(argv[5])};
  const double half_rad = atof(argv[6]) * 3.14159265358979323846 / 180.0 / 2.0;
  const double z = sin(half_rad), w = cos(half_rad), length = sqrt(z * z + w * w);
  const double qz = z / length, qw = w / length;
  const double T_world_guess[12] = {1 - 2 * (qz * qz),
                                    -2 * qz * qw,
                                    0,
                                    guess_m[0],
                                    2 * qz * qw,
                                    1 - 2 * (qz * qz),
                                    0,
                                    guess_m[1],
                                    0,
                                    0,
                                    1,
                                    guess_m[2]};
  sightline_points scan;
  sightline_look look;
  sightline_match match;
  float* numbers = read_scan(argv[2], &scan);
  int error = ask_look(argv[1], info.localizer, guess_m, argc == 8 ? atof(argv[7]) : 0.10, &look);
  if (error == 0) {
    error = sightline_localizer_match(localizer, &scan, T_world_guess, &look, NULL, &match);
  }
  if (error == 0) print(&look, &match);
  if (error != 0) fprintf(stderr, "SL%d %s\n", error, sightline_error_name(error));
  free(numbers);
  sightline_localizer_close(localizer);
  return error != 0 || match.stop == SIGHTLINE_NO_POINTS || match.stop == SIGHTLINE_NO_OVERLAP;
}
