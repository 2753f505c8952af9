#include "formats/surroundings/sharpness.h"

#include <cstdio>

#include "formats/record/cells.h"
#include "formats/record/fields.h"

namespace sightline {
namespace {

bool is_valid(const SharpnessFigures& figures) {
  return are_finite(figures) && figures.mean_plane_variance_m2 >= 0.0;
}

std::string figures_text(const SharpnessFigures& figures) {
  char text[96];
  std::snprintf(text, sizeof text, "mean plane variance %.2f cm2, mean map entropy %.3f nat",
                1e4 * figures.mean_plane_variance_m2, figures.mean_entropy_nat);
  return text;
}

}  // namespace

Result<void> validate(const Sharpness& sharpness) {
  if (!is_valid(sharpness.of_map) || (sharpness.of_given && !is_valid(*sharpness.of_given))) {
    return Error{ErrorCode::kInvalidArtifact, "figures of sharpness are not finite"};
  }
  return {};
}

Table dump(const Sharpness& sharpness) {
  Table table{"sharpness", {}, {}, {}};
  table.columns = {"poses"};
  append_columns<SharpnessFigures>(table.columns);
  append_cells(sharpness.of_map, table.rows.emplace_back(1, "map"));
  if (sharpness.of_given) {
    append_cells(*sharpness.of_given, table.rows.emplace_back(1, "given"));
  }
  return table;
}

std::string to_text(const Sharpness& sharpness) {
  std::string text = "sharpness: " + figures_text(sharpness.of_map);
  if (sharpness.of_given && *sharpness.of_given != sharpness.of_map) {
    text += "; with the given poses: " + figures_text(*sharpness.of_given);
  }
  return text;
}

}  // namespace sightline
