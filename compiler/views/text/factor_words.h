#pragma once

#include <string>
#include <string_view>

namespace sightline {

// A factor in words for people, with its unit: "mean distance of NDs (m)" of r_average
// (schemas/definitions.md has the definitions). A name that has no words here: the name itself.
std::string factor_words(std::string_view name);

}  // namespace sightline
