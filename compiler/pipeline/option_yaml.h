#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "compiler/pipeline/yaml_tree.h"
#include "formats/base/result.h"
#include "passes/pass/options.h"

// Sets options from YAML. Errors carry the line; the file is the caller's to add.

namespace sightline {

// One field from a scalar, or from a list of scalars. Error: bad-value.
Result<void> set_field(const YamlNode& node, OptionField& field);

// Every field that a map names; keys in `others` are left to the caller, and no value at all sets
// nothing. `where` is "section 'gate'". Errors: bad-value, unknown-key with the nearest known one.
Result<void> set_fields(const YamlNode& node, const std::string& where,
                        std::vector<OptionField>& fields,
                        const std::vector<std::string>& others = {});

// unknown-key; `where` is "in section 'gate'" or "at the top level".
Error unknown_key(std::string_view key, std::string_view where,
                  const std::vector<std::string>& known);

Error placed(Error error, const YamlNode& node);

}  // namespace sightline
