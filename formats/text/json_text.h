#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace sightline {

// The text of every JSON that is written: names that are no UTF-8 have U+FFFD in the place of what
// is none, and never end the run; what could steer a terminal is escaped. `indent` of 2 ends with a
// line end; -1: one line without.
std::string json_text(const nlohmann::ordered_json& json, int indent = 2);

}  // namespace sightline
