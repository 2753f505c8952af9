#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace sightline {

// What keeps a document from a JSON schema of draft 4 (where it has an "id") or 7, a fault a line,
// by the validator valijson; empty: nothing does.
std::string schema_faults(const nlohmann::json& schema, const nlohmann::json& document);

}  // namespace sightline
