#pragma once

#include <string_view>

namespace sightline {

// The first bytes of every compiled map (schemas/map_format.md). A high bit, CR LF and a DOS end of
// file: a transfer as text changes one of them.
inline constexpr std::string_view kMapBeginning("\x89SLM\r\n\x1a\n", 8);

}  // namespace sightline
