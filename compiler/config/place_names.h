#pragma once

#include <string>
#include <vector>

namespace sightline {

// What the places of these configurations are called in a model's card: each file's path below the
// deepest folder that holds all of them, so that the same places in another folder have the same
// names. "/data/north/town.yaml", "/data/south/town.yaml": "north/town.yaml", "south/town.yaml".
std::vector<std::string> place_names(const std::vector<std::string>& files);

}  // namespace sightline
