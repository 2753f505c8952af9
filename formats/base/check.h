#pragma once

#include <cstdio>
#include <cstdlib>

// Stops the program when one of our own promises is broken. Bad input is never a check: it is a
// `Result` (formats/base/result.h).
#define SIGHTLINE_CHECK(condition)                                                         \
  do {                                                                                     \
    if (!(condition)) {                                                                    \
      std::fprintf(stderr, "%s:%d: internal error: %s\n", __FILE__, __LINE__, #condition); \
      std::abort();                                                                        \
    }                                                                                      \
  } while (false)
