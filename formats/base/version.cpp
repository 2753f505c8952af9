#include "formats/base/version.h"

namespace sightline {

std::string program_version() { return SIGHTLINE_VERSION; }

}  // namespace sightline
