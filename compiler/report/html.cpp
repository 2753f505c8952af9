#include "compiler/report/html.h"

#include <array>
#include <cmath>
#include <cstdio>

#include "formats/quoted_text.h"

namespace sightline {
namespace {

struct Rgb {
  double red = 0.0;
  double green = 0.0;
  double blue = 0.0;
};

// Eleven even steps of matplotlib's viridis (public domain), which rises in brightness all the way
// and reads the same to colour-blind people.
constexpr std::array<Rgb, 11> kViridis = {{{68, 1, 84},
                                           {72, 36, 117},
                                           {65, 68, 135},
                                           {53, 95, 141},
                                           {42, 120, 142},
                                           {33, 145, 140},
                                           {34, 168, 132},
                                           {68, 191, 112},
                                           {122, 209, 81},
                                           {189, 223, 38},
                                           {253, 231, 37}}};

std::string viridis(double share) {
  const double place = share * static_cast<double>(kViridis.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(place), kViridis.size() - 2);
  const double part = place - static_cast<double>(below);
  const Rgb& a = kViridis[below];
  const Rgb& b = kViridis[below + 1];
  const auto mix = [&](double from, double to) {
    return static_cast<unsigned>(std::lround(from + part * (to - from)));
  };
  std::array<char, 8> text{};
  std::snprintf(text.data(), text.size(), "#%02x%02x%02x", mix(a.red, b.red) & 255U,
                mix(a.green, b.green) & 255U, mix(a.blue, b.blue) & 255U);
  return text.data();
}

std::string colours_from(std::size_t count, double first, double last) {
  std::string css;
  for (std::size_t i = 0; i < count; ++i) {
    const double share = count > 1 ? static_cast<double>(i) / static_cast<double>(count - 1) : 0.0;
    css += "--range-" + std::to_string(i) + ":" + viridis(first + share * (last - first)) + ";";
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
