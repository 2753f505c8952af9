#include "compiler/views/report/sections/html.h"

#include <array>
#include <cmath>
#include <cstdio>

#include "compiler/views/picture/colours.h"
#include "formats/text/quoted_text.h"

namespace sightline {
namespace {

std::string colours_from(std::size_t count, double first, double last) {
  std::string css;
  for (std::size_t i = 0; i < count; ++i) {
    const double share = count > 1 ? static_cast<double>(i) / static_cast<double>(count - 1) : 0.0;
    css += "--range-" + std::to_string(i) + ":" +
           colour_name(viridis(first + share * (last - first))) + ";";
  }
  return css;
}

}  // namespace

std::string paragraph(const std::string& text) { return "<p>" + xml_text(text) + "</p>\n"; }

std::string html_table(const TextGrid& grid, const std::string& caption) {
  std::string html = "<div class=\"scroll\"><table><caption>" + xml_text(caption) + "</caption>\n";
  for (std::size_t row = 0; row < grid.size(); ++row) {
    html += row == 0 ? "<thead><tr>" : "<tr>";
    for (std::size_t column = 0; column < grid[row].size(); ++column) {
      const bool is_head = row == 0 || column == 0;
      html += is_head ? "<th scope=\"" + std::string(row == 0 ? "col" : "row") + "\">" : "<td>";
      html += xml_text(grid[row][column]) + (is_head ? "</th>" : "</td>");
    }
    html += row == 0 ? "</tr></thead><tbody>\n" : "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

std::string fact_table(const std::vector<std::pair<std::string, std::string>>& facts) {
  std::string html = "<dl class=\"facts\">\n";
  for (const auto& [name, value] : facts) {
    html += "<dt>" + xml_text(name) + "</dt><dd>" + xml_text(value) + "</dd>\n";
  }
  return html + "</dl>\n";
}

std::string html_figure(const Figure& figure) {
  std::string html =
      "<figure id=\"" + figure.id + "\">\n<div class=\"still\">" + figure.picture_html + "</div>\n";
  if (!figure.live.empty()) {
    html += "<div class=\"live\" data-drawing=\"" + figure.live + "\"></div>\n";
  }
  return html + "<figcaption><b>" + xml_text(figure.name) + "</b> " + xml_text(figure.caption) +
         "</figcaption>\n</figure>\n";
}

std::string range_colour(std::size_t range) { return "var(--range-" + std::to_string(range) + ")"; }

std::string range_colours_css(std::size_t count) {
  return ":root{" + colours_from(count, 0.0, 0.88) +
         "}\n@media screen and (prefers-color-scheme:dark){:root{" + colours_from(count, 0.3, 1.0) +
         "}}\n";
}

std::string centimetres(double length_m) { return fixed(100.0 * length_m, 1); }
std::string percent(double share) { return fixed(100.0 * share, 1); }

std::string limit_text(double limit_m) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%g cm", 100.0 * limit_m);
  return text.data();
}

std::string metres(double length_m) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%g m", length_m);
  return text.data();
}

}  // namespace sightline
