#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "formats/drive/drive.h"

namespace sightline {

// "what: a; b; c; ...": the first five of the places that were found, by their to_text().
template <class Found>
std::string with_first_places(const std::string& what, const std::vector<Found>& found,
                              const Drive& drive) {
  constexpr std::size_t kMostTold = 5;
  std::string text = what;
  for (std::size_t i = 0; i < std::min(found.size(), kMostTold); ++i) {
    text += (i == 0 ? ": " : "; ") + to_text(found[i], drive);
  }
  if (found.size() > kMostTold) text += "; ...";
  return text;
}

}  // namespace sightline
