#include "compiler/views/picture/charts/chart.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

TEST(ChartAxis, TicksAreRoundAndWithinTheSpan) {
  const Axis axis = axis_of({0.0, 47.0}, 6, true);
  EXPECT_THAT(axis.ticks, ElementsAre(0.0, 10.0, 20.0, 30.0, 40.0, 50.0));
  EXPECT_EQ(axis.label(30.0), "30");
  const Axis fine = axis_of({0.013, 0.049}, 4, false);
  EXPECT_THAT(fine.label(fine.ticks[0]), "0.02");
  EXPECT_EQ(fine.span.to, 0.049);
}

TEST(ChartAxis, AnySpanHasAFewTicks) {
  for (double size = 1e-6; size < 1e7; size *= 3.7) {
    for (const double from : {-0.3 * size, 0.0, 17.0 * size}) {
      const Axis axis = axis_of({from, from + size}, 6, false);
      EXPECT_GE(axis.ticks.size(), 2U) << from << " " << size;
      EXPECT_LE(axis.ticks.size(), 8U) << from << " " << size;
      for (const double tick : axis.ticks) {
        EXPECT_GE(axis.share(tick), -1e-6);
        EXPECT_LE(axis.share(tick), 1.0 + 1e-6);
      }
    }
  }
  EXPECT_GT(axis_of({5.0, 5.0}, 6, true).span.to, 5.0);
}

Chart line_of(const std::vector<double>& y) {
  Chart chart;
  chart.x_label = "way (m)";
  chart.y_label = "error (cm)";
  ChartSeries series = {"10 m", "#123456", Mark::kLine, 1.5, false, {}, y};
  for (std::size_t i = 0; i < y.size(); ++i) series.x.push_back(static_cast<double>(i));
  chart.series = {series};
  return chart;
}

TEST(Chart, NamesAxesAndSeries) {
  const std::string svg = chart_svg(line_of({1.0, 4.0, 2.0}));
  EXPECT_THAT(svg, HasSubstr(">way (m)</text>"));
  EXPECT_THAT(svg, HasSubstr(">error (cm)</text>"));
  EXPECT_THAT(svg, HasSubstr(">10 m</text>"));
  EXPECT_THAT(svg, HasSubstr("stroke:#123456"));
}

// Three points across a plot from 62 to 746 px.
TEST(Chart, PointsStandWhereTheyShould) {
  EXPECT_THAT(chart_svg(line_of({1.0, 4.0, 2.0})), HasSubstr("d=\"M62.0 254.0L404.0 30.0L746.0"));
  EXPECT_THAT(chart_svg(line_of({1.0, 4.0, 2.0})),
              HasSubstr("data-plot=\"62.0 746.0 30.0 254.0 0 2\""));
}

TEST(Chart, ANumberThatIsNoneBreaksTheLine) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  const std::string svg = chart_svg(line_of({1.0, none, 2.0}));
  EXPECT_THAT(svg, HasSubstr("d=\"M62.0 254.0M746.0 30.0\""));
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
}

TEST(Chart, ALongLineKeepsItsPeaks) {
  std::vector<double> y(100'000, 1.0);
  y[54'321] = 9.0;
  y[77'777] = 0.0;
  const std::string svg = chart_svg(line_of(y));
  EXPECT_LT(svg.size(), 40'000U);
  EXPECT_NE(svg.find(" 52.4L"), std::string::npos);   // the greatest, on an axis to 10
  EXPECT_NE(svg.find(" 254.0L"), std::string::npos);  // the least
}

TEST(Chart, TextsAreEscaped) {
  Chart chart = line_of({1.0, 2.0});
  chart.series[0].name = "a<b & \"c\"";
  EXPECT_THAT(chart_svg(chart), HasSubstr("a&lt;b &amp; &quot;c&quot;"));
}

TEST(Chart, BarsStandOnZeroBesideEachOther) {
  Chart chart;
  chart.series = {{"a", "red", Mark::kBars, 1.0, false, {10, 20}, {5, 6}},
                  {"b", "blue", Mark::kBars, 1.0, false, {10, 20}, {7, 8}}};
  chart.least_x = 0.0;
  chart.greatest_x = 30.0;
  const std::string svg = chart_svg(chart);
  // 22.8 px a metre: a group is 171 px wide, each bar 94 % of its half.
  EXPECT_THAT(svg, HasSubstr("x=\"204.5\""));
  EXPECT_THAT(svg, HasSubstr("x=\"290.0\""));
  EXPECT_THAT(svg, HasSubstr("width=\"80.4\""));
}

}  // namespace
}  // namespace sightline
