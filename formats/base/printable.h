#pragma once

#include <string>
#include <string_view>

namespace sightline {

// Text from a file of strangers, fit for a terminal: control characters, also those of C1, and
// bytes that are no UTF-8 become "\x1b". Line ends and tabs stay.
std::string printable(std::string_view text);

}  // namespace sightline
