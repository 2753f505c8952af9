#include "formats/picture/calibration_picture.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(CalibrationPicture, PutsAKeptPromiseOnTheDiagonal) {
  Evaluation evaluation;
  evaluation.limits_m = {0.1, 0.25};
  evaluation.reliability = {{0.1, 0.5, 0.5, 40}, {0.1, 1.0, 0.9, 10}, {0.25, 0.0, 0.0, 1}};
  const std::string svg = calibration_picture_svg(evaluation);
  // The square goes from 50 to 450, up is more.
  EXPECT_NE(svg.find("points=\"250.0,250.0 450.0,90.0 \""), std::string::npos) << svg;
  EXPECT_NE(svg.find("points=\"50.0,450.0 \""), std::string::npos) << svg;
  EXPECT_NE(svg.find("10 pairs"), std::string::npos);
  EXPECT_NE(svg.find(">25 cm<"), std::string::npos);
  EXPECT_EQ(svg.substr(svg.size() - 7), "</svg>\n");
}

}  // namespace
}  // namespace sightline
