#pragma once

#include <string>

namespace sightline {

// "0.1.0": the version of the CMake project, which is the one place where it is written.
std::string program_version();

}  // namespace sightline
