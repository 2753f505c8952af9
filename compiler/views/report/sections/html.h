#pragma once

#include <string>
#include <vector>

#include "compiler/views/picture/charts/chart.h"
#include "formats/map/compiled_map.h"
#include "formats/text/numbers.h"
#include "formats/text/table.h"

// Pieces of the page. Texts are escaped here; what is called html is not.

namespace sightline {

struct Section {
  std::string id;
  std::string title;
  std::string html;
};

std::string paragraph(const std::string& text);

// The first row is the head; the first column names the rows; numbers stand under each other.
std::string html_table(const TextGrid& grid, const std::string& caption);

TextGrid transposed(const TextGrid& grid);

// Names and values, two columns without a head.
using Facts = std::vector<std::pair<std::string, std::string>>;
std::string fact_table(const Facts& facts);

// A figure: what it is called, what one sees, and a picture. `live`: the name of the drawing that
// the page's scripts put in its place; empty: the picture stays.
struct Figure {
  std::string id;
  std::string name;     // "Error by range."
  std::string caption;  // what one sees
  std::string picture_html;
  std::string live;
};
std::string html_figure(const Figure& figure);

// Colours of the page, the same in its style sheet.
inline const std::string kBlue = "var(--blue)";
inline const std::string kOrange = "var(--orange)";
inline const std::string kGreen = "var(--green)";
inline const std::string kGrey = "var(--grey)";
inline const std::string kPink = "var(--pink)";
std::string limit_colour(std::size_t limit);  // blue, orange and green in turn
std::string range_colour(std::size_t range);
std::string look_colour(std::size_t look);

// The style that gives ranges and looks their colours, from dark violet to yellow on paper and
// paler where the page is dark (viridis). Ranges stand by their length; those that some site looks
// share most of the colours, the shorter and the longer ones have what is left at both ends. Of
// looks only those that some site takes have a colour of their own. Besides --range-zero, of 0 m,
// and --scale-0 to --scale-8, the row of colours itself.
std::string colours_css(const CompiledMap& map);

std::string limit_text(double limit_m);  // "10 cm"
std::string metres(double length_m);     // "15 m"

}  // namespace sightline
