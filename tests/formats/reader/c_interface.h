#ifndef SIGHTLINE_TESTS_C_INTERFACE_H
#define SIGHTLINE_TESTS_C_INTERFACE_H

#include "formats/reader/sightline_reader.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Opens, looks up once and closes. */
int range_from_c(const char* path, const double position_world_m[3], double limit_m,
                 sightline_range* range);

#ifdef __cplusplus
}
#endif

#endif
