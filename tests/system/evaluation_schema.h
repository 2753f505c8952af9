#pragma once

#include <string>

namespace sightline {

// What a document breaks of schemas/evaluation.schema.json; empty where it keeps all of it.
std::string fault_of_evaluation(const std::string& json_text);

}  // namespace sightline
