#include "compiler/views/report/sections/html.h"

#include <fmt/format.h>

#include <set>

#include "compiler/views/picture/raster.h"
#include "formats/text/quoted_text.h"

namespace sightline {
namespace {

// The colours at both ends of the row.
struct Tones {
  double first = 0.0;
  double last = 1.0;
};
constexpr Tones kOnPaper = {0.0, 0.88};
constexpr Tones kOnBlack = {0.3, 1.0};

constexpr std::size_t kScaleSteps = 9;

// Characters of a cell that may take several lines.
constexpr std::size_t kLongText = 40;

// Ranges that no site looks, of all colours at most.
constexpr double kRareShare = 0.5;

// Indices into the choice that some site takes.
std::set<std::size_t> occurring(const RangeTable& table) {
  return {table.range_index.begin(), table.range_index.end()};
}

// Where a length stands in the row of colours.
class LengthScale {
 public:
  explicit LengthScale(const RangeTable& ranges) : longest_m_(ranges.looks.back().range_m) {
    const std::set<std::size_t> taken = occurring(ranges);
    if (taken.empty()) return;
    least_m_ = ranges.looks[*taken.begin()].range_m;
    greatest_m_ = ranges.looks[*taken.rbegin()].range_m;
    low_ = kRareShare * least_m_ / longest_m_;
    high_ = 1.0 - kRareShare * (1.0 - greatest_m_ / longest_m_);
    if (least_m_ == greatest_m_) low_ = high_ = (low_ + high_) / 2.0;
  }

  [[nodiscard]] double share(double length_m) const {
    if (length_m <= least_m_) return least_m_ > 0.0 ? low_ * length_m / least_m_ : low_;
    if (length_m >= greatest_m_) {
      const double rest_m = longest_m_ - greatest_m_;
      return rest_m > 0.0 ? high_ + (1.0 - high_) * (length_m - greatest_m_) / rest_m : high_;
    }
    return low_ + (high_ - low_) * (length_m - least_m_) / (greatest_m_ - least_m_);
  }

 private:
  double longest_m_ = 0.0;
  double least_m_ = 0.0;  // of those that some site looks
  double greatest_m_ = 0.0;
  double low_ = 0.0;  // their shares
  double high_ = 1.0;
};

std::string colour_css(const std::string& name, double share, const Tones& tones) {
  const Colour colour = viridis(tones.first + share * (tones.last - tones.first));
  return fmt::format("--{}:{};", name, colour_name(colour));
}

// The looks that are taken spread over the row; each other has the colour of the one before it.
std::string look_colours(const RangeTable& looks, const Tones& tones) {
  const std::set<std::size_t> taken = occurring(looks);
  std::string css;
  double share = 0.0;
  double rank = 0.0;
  for (std::size_t i = 0; i < looks.looks.size(); ++i) {
    if (taken.contains(i)) {
      share = taken.size() > 1 ? rank / static_cast<double>(taken.size() - 1) : 0.5;
      rank += 1.0;
    }
    css += colour_css(concat("look-", i), share, tones);
  }
  return css;
}

std::string colours_of(const CompiledMap& map, const Tones& tones) {
  const LengthScale scale(map.ranges);
  std::string css = colour_css("range-zero", scale.share(0.0), tones);
  for (std::size_t i = 0; i < map.ranges.looks.size(); ++i) {
    css += colour_css(fmt::format("range-{}", i), scale.share(map.ranges.looks[i].range_m), tones);
  }
  for (std::size_t i = 0; i < kScaleSteps; ++i) {
    css += colour_css(concat("scale-", i),
                      static_cast<double>(i) / static_cast<double>(kScaleSteps - 1), tones);
  }
  if (map.looks) css += look_colours(map.looks->ranges, tones);
  return css;
}

}  // namespace

std::string paragraph(const std::string& text) { return concat("<p>", xml_text(text), "</p>\n"); }

std::string html_table(const TextGrid& grid, const std::string& caption) {
  std::string html = concat("<div class=\"scroll\" tabindex=\"0\"><table><caption>",
                            xml_text(caption), "</caption>\n");
  for (std::size_t row = 0; row < grid.size(); ++row) {
    html += row == 0 ? "<thead><tr>" : "<tr>";
    for (std::size_t column = 0; column < grid[row].size(); ++column) {
      const bool is_head = (row == 0 || column == 0) && !grid[row][column].empty();
      const char* td = grid[row][column].size() > kLongText ? "<td class=\"text\">" : "<td>";
      html += is_head ? concat("<th scope=\"", row == 0 ? "col" : "row", "\">") : td;
      html += xml_text(grid[row][column]) + (is_head ? "</th>" : "</td>");
    }
    html += row == 0 ? "</tr></thead><tbody>\n" : "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

TextGrid transposed(const TextGrid& grid) {
  TextGrid columns(grid.front().size());
  for (const std::vector<std::string>& row : grid) {
    for (std::size_t i = 0; i < columns.size(); ++i) columns[i].push_back(row[i]);
  }
  return columns;
}

std::string fact_table(const Facts& facts) {
  std::string html = "<dl class=\"facts\">\n";
  for (const auto& [name, value] : facts) {
    html += concat("<dt>", xml_text(name), "</dt><dd>", xml_text(value), "</dd>\n");
  }
  return html + "</dl>\n";
}

std::string html_figure(const Figure& figure) {
  std::string html = concat("<figure id=\"", figure.id, "\">\n<div class=\"still\" tabindex=\"0\">",
                            figure.picture_html, "</div>\n");
  if (!figure.live.empty()) {
    html += concat("<div class=\"live\" data-drawing=\"", figure.live, "\"></div>\n");
  }
  return concat(html, "<figcaption><b>", xml_text(figure.name), "</b> ", xml_text(figure.caption),
                "</figcaption>\n</figure>\n");
}

std::string limit_colour(std::size_t limit) {
  const std::string colours[] = {kBlue, kOrange, kGreen};
  return colours[limit % 3];
}

std::string range_colour(std::size_t range) { return concat("var(--range-", range, ")"); }

std::string look_colour(std::size_t look) { return concat("var(--look-", look, ")"); }

std::string colours_css(const CompiledMap& map) {
  return concat(":root{", colours_of(map, kOnPaper),
                "}\n@media screen and (prefers-color-scheme:dark){:root{",
                colours_of(map, kOnBlack), "}}\n");
}

std::string limit_text(double limit_m) { return fmt::format("{:g} cm", 100.0 * limit_m); }

std::string metres(double length_m) { return fmt::format("{:g} m", length_m); }

}  // namespace sightline
