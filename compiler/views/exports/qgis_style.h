#pragma once

#include <string>
#include <vector>

namespace sightline {

// A style of QGIS 3 (QML): points coloured by the value of an attribute, one class for each range.
std::string qgis_range_style(const std::string& attribute, const std::vector<double>& ranges_m);

// A plain grey line.
std::string qgis_line_style();

}  // namespace sightline
