#include "compiler/cli/console/color.h"

#include <unistd.h>

#include <cstdlib>

namespace sightline {

bool allows_color(int descriptor) {
  const char* const no_color = std::getenv("NO_COLOR");
  const bool is_forbidden = no_color != nullptr && no_color[0] != '\0';
  return !is_forbidden && ::isatty(descriptor) == 1;
}

}  // namespace sightline
