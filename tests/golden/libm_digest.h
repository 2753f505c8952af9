#pragma once

#include <string>

namespace sightline::golden {

// SHA-256 of what the C library makes of some thousand numbers: it has several variants of its
// functions, of which the processor and GLIBC_TUNABLES choose one, and their last bits differ.
std::string libm_digest();

}  // namespace sightline::golden
