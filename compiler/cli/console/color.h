#pragma once

namespace sightline {

// Whether text on this file descriptor may have colours: it is a terminal, and NO_COLOR is absent
// or empty (no-color.org).
bool allows_color(int descriptor);

}  // namespace sightline
