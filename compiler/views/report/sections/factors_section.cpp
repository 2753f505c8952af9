#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <numeric>

#include "compiler/views/report/sections/sections.h"
#include "compiler/views/text/factor_words.h"
#include "formats/text/quoted_text.h"

namespace sightline {
namespace {

// A cell coloured by the strength of a correlation: blue is negative, orange positive.
std::string correlation_cell(double correlation) {
  return fmt::format("<td class=\"heat\" style=\"--share:{:.0f}%;--hue:var(--{})\">{:.2f}</td>",
                     80.0 * std::min(1.0, std::abs(correlation)),
                     correlation < 0.0 ? "blue" : "orange", correlation);
}

double strength(const FactorReport& report, std::size_t factor) {
  double sum = 0.0;
  for (const FactorsAtRange& range : report.ranges) sum += std::abs(range.rank_correlation[factor]);
  return sum;
}

std::string correlation_table(const FactorReport& report) {
  std::vector<std::size_t> order(report.factors.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return strength(report, a) > strength(report, b);
  });
  std::string html =
      "<div class=\"scroll\" tabindex=\"0\"><table id=\"correlations\"><caption>Rank correlation "
      "(Spearman) of each factor with the measured mean error, strongest first</caption>\n"
      "<thead><tr><th scope=\"col\">factor</th>";
  for (const FactorsAtRange& range : report.ranges) {
    html += concat("<th scope=\"col\">", metres(range.range_m), "</th>");
  }
  html += "</tr></thead><tbody>\n";
  for (const std::size_t factor : order) {
    html +=
        concat("<tr><th scope=\"row\">", xml_text(factor_words(report.factors[factor])), "</th>");
    for (const FactorsAtRange& range : report.ranges) {
      html += correlation_cell(range.rank_correlation[factor]);
    }
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

std::string expectation_table(const FactorReport& report) {
  TextGrid rows = {{"range (m)", "points predicted", "points measured",
                    "correlation over sites (r)", "time predicted (ms)", "time measured (ms)"}};
  for (const FactorsAtRange& range : report.ranges) {
    rows.push_back({fixed(range.range_m, 0), fixed(range.virtual_points, 0),
                    fixed(range.measured_points, 0), fixed(range.point_correlation, 3),
                    fixed(range.expected_time_ms, 2), fixed(range.measured_time_ms, 2)});
  }
  return html_table(transposed(rows),
                    concat("Points and time predicted from the map alone, and measured; r = ",
                           fixed(report.point_correlation, 3), " over all ranges"));
}

// Of the model's card: factors by how much worse held-out places are predicted without them.
std::string importance_figure(const CompiledMap& map) {
  constexpr std::size_t kMostShown = 12;
  std::vector<CardFigure> importances;
  std::ranges::copy_if(
      map.model.figures, std::back_inserter(importances),
      [](const CardFigure& figure) { return figure.kind == CardFigureKind::kImportance_m; });
  if (importances.empty()) return "";
  std::ranges::stable_sort(importances, std::greater(), &CardFigure::value);
  if (importances.size() > kMostShown) importances.resize(kMostShown);
  TextGrid grid = {{"factor", "importance (mm)"}};
  for (const CardFigure& figure : importances) {
    grid.push_back({factor_words(figure.of), fixed(1000.0 * figure.value, 2)});
  }
  return html_table(grid,
                    "Importance: increase of the prediction error at held-out places when the "
                    "values of a factor are shuffled");
}

}  // namespace

Section factors_section(const FactorReport& factors, const CompiledMap& map) {
  Section section = {"factors", "Factors: properties of the map that predict the error", ""};
  section.html = paragraph(
                     "Factors are computed from the map alone, at every site and range. Orange: "
                     "the error increases with the factor; blue: it decreases.") +
                 correlation_table(factors) + expectation_table(factors) + importance_figure(map);
  return section;
}

}  // namespace sightline
