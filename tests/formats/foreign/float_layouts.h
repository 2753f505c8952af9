#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "formats/base/random.h"
#include "formats/foreign/clouds/float_columns.h"
#include "tests/formats/foreign/foreign_files.h"

namespace sightline {

// One letter a column: x y z, i a strength in 0 to 1, I one in 0 to 255, r a ring, t a time, g a
// colour, n a part of a normal, l a label, 0 zero, 1 one, d a distance.
inline float number_in(char column, const Eigen::Vector3d& point_m, std::size_t index,
                       Random& random) {
  switch (column) {
    case 'x':
      return static_cast<float>(point_m.x());
    case 'y':
      return static_cast<float>(point_m.y());
    case 'z':
      return static_cast<float>(point_m.z());
    case 'i':
      return static_cast<float>(std::floor(100.0 * random.uniform()) / 100.0);
    case 'I':
      return static_cast<float>(random.below(256));
    case 'r':
      return static_cast<float>(index % 16);
    case 't':
      return 4e-6F * static_cast<float>(index);
    case 'g':
      return static_cast<float>(30 + static_cast<int>(3.0 * std::abs(point_m.x())) % 200);
    case 'n':
      return static_cast<float>(std::clamp(0.5 * random.normal(), -1.0, 1.0));
    case 'l':
      return static_cast<float>(10 + random.below(5));
    case 'd':
      return static_cast<float>(point_m.norm());
    default:
      return column == '1' ? 1.0F : 0.0F;
  }
}

inline std::string float_file(const std::vector<Eigen::Vector3d>& points_m,
                              std::string_view columns) {
  Random random(3);
  std::string bytes;
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    for (const char column : columns)
      bytes += as_bytes({number_in(column, points_m[i], i, random)});
  }
  return bytes;
}

inline const std::vector<std::string> kLayouts = {
    "xyz",      "xyzi",   "xyzI",     "xyz0",       "xyzi0",   "xyzir",    "xyzit",
    "xyzirt",   "xyzggg", "xyznnn",   "xyzil",      "xyzgggl", "xyzinnnd", "xyz1i000",
    "xyzirtdl", "xyzitr", "xyzitrgd", "xyziltrgdn", "xyz001",  "xyzi001d", "xyzir000"};

inline FloatCounts fitting(std::string_view text) {
  return fitting_counts(std::as_bytes(std::span(text)));
}

}  // namespace sightline
