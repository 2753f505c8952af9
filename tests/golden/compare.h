#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/golden/step_outputs.h"

// Which step changed, and why that is wrong or what is left to do.

namespace sightline::golden {

// Golden texts by the name of their file, "town16/build-ndt.txt".
using GoldenFiles = std::map<std::string, std::string>;

GoldenFiles golden_files(const std::vector<RunOutput>& runs);

// Empty where all runs of a town are as their golden files say. Otherwise each step whose output
// changed though its inputs did not, in running order, with the first differing lines; then the
// names of the steps after them, whose own part in it cannot be distinguished; then files of no
// step.
std::string compare(const std::vector<RunOutput>& runs, const GoldenFiles& kept);

}  // namespace sightline::golden
