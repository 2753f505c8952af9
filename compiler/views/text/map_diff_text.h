#pragma once

#include <string>

#include "formats/map/diff/map_diff.h"

namespace sightline {

// What changed on one screen, the most important first: at most 30 lines of 120 columns.
std::string summary_text(const MapDiff& diff);

// All that changed, the most important first: what changed along the route as stretches, of which
// the longest are listed, then the figures of each limit and what else changed. Several lines.
std::string to_text(const MapDiff& diff);

// The same for a pull request: GitHub's and GitLab's Markdown.
std::string to_markdown(const MapDiff& diff);

}  // namespace sightline
