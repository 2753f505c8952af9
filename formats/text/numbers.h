#pragma once

#include <string>

// Numbers for people.

namespace sightline {

std::string fixed(double value, int decimals);  // "2.50"
std::string in_percent(double share);           // "94.3", of a column that names the unit
std::string percent(double share);              // "94.3 %"
std::string whole_percent(double share);        // "94 %"; halves go away from 0
std::string in_centimetres(double length_m);    // "8.3", of a column that names the unit

}  // namespace sightline
