#pragma once

#include <string>
#include <vector>

#include "passes/pass/options.h"

namespace sightline {

// The value of a field, in the words of both YAML and JSON.
std::string json_text(const OptionField& field);

// JSON Schema (draft 7) of a map of these fields, as "properties" holds it: an object with a schema
// for each name. The values that the fields hold now are its defaults.
std::string properties_schema(const std::vector<OptionField>& fields);

}  // namespace sightline
