#include "formats/text/text_grid.h"

#include <algorithm>

namespace sightline {

std::string aligned(const TextGrid& grid, FirstColumn first) {
  std::vector<std::size_t> widths;
  for (const std::vector<std::string>& row : grid) {
    widths.resize(std::max(widths.size(), row.size()), 0);
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (const std::vector<std::string>& row : grid) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string space(widths[i] - row[i].size(), ' ');
      if (i > 0) text += "  ";
      text += i == 0 && first == FirstColumn::kLeft ? row[i] + space : space + row[i];
    }
    text += "\n";
  }
  return text;
}

}  // namespace sightline
