#include "compiler/views/picture/charts/calibration_chart.h"
#include "compiler/views/picture/charts/chart.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sightline {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

Evaluation judged() {
  Evaluation evaluation;
  evaluation.limits_m = {0.1, 0.25};
  evaluation.reliability = {{0.1, 0.5, 0.5, 40}, {0.1, 1.0, 0.9, 10}, {0.25, 0.0, 0.0, 1}};
  return evaluation;
}

TEST(CalibrationChart, PutsAKeptPromiseOnTheDiagonal) {
  const Chart chart = calibration_chart(judged(), {"grey", {"blue", "red"}});
  ASSERT_EQ(chart.series.size(), 5U);  // the diagonal, and a line with points a limit
  EXPECT_EQ(chart.series[0].colour, "grey");
  EXPECT_EQ(chart.series[0].x, chart.series[0].y);
  const ChartSeries& points = chart.series[2];
  EXPECT_EQ(points.name, "within 10 cm");
  EXPECT_EQ(points.colour, "blue");
  EXPECT_THAT(points.x, ElementsAre(50.0, 100.0));
  EXPECT_THAT(points.y, ElementsAre(50.0, 90.0));
  EXPECT_EQ(chart.series[4].name, "within 25 cm");
  EXPECT_EQ(chart.series[4].colour, "red");
  // The middle of 404 px by 364 px, below a legend of one row.
  const std::string svg = chart_svg(chart);
  EXPECT_THAT(svg, HasSubstr("cx=\"264.0\" cy=\"212.0\" r=\"9.0\"")) << svg;
}

TEST(CalibrationChart, GivesAQuarterOfThePairsAQuarterOfTheArea) {
  const Chart chart = calibration_chart(judged(), {});
  ASSERT_EQ(chart.series[2].sizes_px.size(), 2U);
  EXPECT_DOUBLE_EQ(chart.series[2].sizes_px[1], 0.5 * chart.series[2].sizes_px[0]);
}

TEST(CalibrationChart, OfNoPairsHasItsDiagonalAlone) {
  Evaluation evaluation = judged();
  evaluation.reliability.clear();
  const std::string svg = chart_svg(calibration_chart(evaluation, {}));
  EXPECT_EQ(svg.find("<circle cx=\"264"), std::string::npos);
  EXPECT_THAT(svg, HasSubstr("exact prediction"));
}

}  // namespace
}  // namespace sightline
