#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/golden/step_outputs.h"

// Which step changed, and why that is wrong or what is left to do.

namespace sightline::golden {

// Golden texts by file name.
using GoldenFiles = std::map<std::string, std::string>;

GoldenFiles golden_files(const RunOutput& run);

// Empty where a run is as its golden files say. Otherwise each step whose output changed though its
// inputs did not, in running order, with the first differing lines; then the names of the steps
// after them, which may be as they are; then files that belong to no step.
std::string compare(const RunOutput& run, const GoldenFiles& kept);

}  // namespace sightline::golden
