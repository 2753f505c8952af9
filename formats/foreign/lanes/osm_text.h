#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/base/result.h"

// Additions to a map in OpenStreetMap's XML that leave every other byte of it as it was, so that a
// version control shows them alone.

namespace sightline {

using OsmTags = std::vector<std::pair<std::string, std::string>>;  // keys and values

// A node or way to be added.
struct OsmElement {
  std::string head;               // "node id=\"7\" lat=\"\" lon=\"\""
  std::vector<std::string> refs;  // of a way, its nodes
  OsmTags tags;
};

struct OsmAdditions {
  std::vector<OsmTags> of_relations;  // of each relation of the file, in its order; may be none
  std::vector<OsmElement> nodes;      // stand before the first way
  std::vector<OsmElement> ways;       // stand before the first relation
};

// Marks the nodes and ways that were added.
inline constexpr std::pair<std::string_view, std::string_view> kAddedBy = {"added_by", "sightline"};

// The text without what an earlier export added: the elements marked with kAddedBy, and the tags of
// relations whose keys begin with one of these words.
// Error: malformed-text (elements that do not end, no <osm>).
Result<std::string> without_additions(std::string_view text,
                                      const std::vector<std::string_view>& key_prefixes);

// The text with them, indented and with line ends as it has them. Each element is marked with
// kAddedBy. Errors: malformed-text as above, or where the text has not as many relations as
// additions are for.
Result<std::string> with_additions(std::string_view text, const OsmAdditions& additions);

}  // namespace sightline
