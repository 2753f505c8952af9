#include "formats/surroundings/sharpness.h"

#include <cmath>
#include <cstdio>

namespace sightline {
namespace {

bool is_valid(const SharpnessFigures& figures) {
  return std::isfinite(figures.mean_entropy_nat) && std::isfinite(figures.mean_plane_variance_m2) &&
         figures.mean_plane_variance_m2 >= 0.0;
}

std::vector<Cell> row_of(const std::string& poses, const SharpnessFigures& figures) {
  return {poses, figures.mean_entropy_nat, static_cast<std::int64_t>(figures.entropy_points),
          figures.mean_plane_variance_m2, static_cast<std::int64_t>(figures.plane_points)};
}

void encode_figures(const SharpnessFigures& figures, ByteWriter& writer) {
  writer.put(figures.mean_entropy_nat);
  writer.put(figures.entropy_points);
  writer.put(figures.mean_plane_variance_m2);
  writer.put(figures.plane_points);
}

void decode_figures(ByteReader& reader, SharpnessFigures& figures) {
  reader.get(figures.mean_entropy_nat);
  reader.get(figures.entropy_points);
  reader.get(figures.mean_plane_variance_m2);
  reader.get(figures.plane_points);
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
    return Error{ErrorCode::kInvalidArtifact, "figures of sharpness are no numbers"};
  }
  return {};
}

Table dump(const Sharpness& sharpness) {
  Table table;
  table.name = "sharpness";
  table.columns = {"poses", "mean_entropy_nat", "entropy_points", "mean_plane_variance_m2",
                   "plane_points"};
  table.rows.push_back(row_of("map", sharpness.of_map));
  if (sharpness.of_given) table.rows.push_back(row_of("given", *sharpness.of_given));
  return table;
}

void encode(const Sharpness& sharpness, ByteWriter& writer) {
  encode_figures(sharpness.of_map, writer);
  writer.put<std::uint8_t>(sharpness.of_given ? 1 : 0);
  if (sharpness.of_given) encode_figures(*sharpness.of_given, writer);
}

void decode(ByteReader& reader, Sharpness& sharpness) {
  decode_figures(reader, sharpness.of_map);
  std::uint8_t has_given = 0;
  reader.get(has_given);
  if (has_given > 1) reader.fail();
  if (has_given == 1) decode_figures(reader, sharpness.of_given.emplace());
}

std::string to_text(const Sharpness& sharpness) {
  std::string text = "sharpness: " + figures_text(sharpness.of_map);
  if (sharpness.of_given && *sharpness.of_given != sharpness.of_map) {
    text += "; with the given poses: " + figures_text(*sharpness.of_given);
  }
  return text;
}

}  // namespace sightline
