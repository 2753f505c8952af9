#pragma once

#include <cstddef>

#include "formats/drive/drive.h"

namespace sightline {

// `count` scans of a drive from the `first` on as a drive of their own: scans count from 0 anew.
Drive stretch_of(const Drive& drive, std::size_t first, std::size_t count);

}  // namespace sightline
