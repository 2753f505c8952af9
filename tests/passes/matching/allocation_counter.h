#pragma once

#include <cstddef>

namespace sightline {

// Calls of operator new so far, by any thread, in a program that links allocation_counter.cpp.
std::size_t allocation_count();

}  // namespace sightline
