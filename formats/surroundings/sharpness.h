#pragma once

#include <cstdint>
#include <optional>

#include "formats/artifact.h"
#include "formats/record/fields.h"

namespace sightline {

// How sharp scans laid on each other are ("Sharpness" in schemas/definitions.md, v2). Smaller is
// sharper; figures of two drives do not compare, those of two trajectories of one drive do.
struct SharpnessFigures {
  double mean_entropy_nat = 0.0;  // of the normal distributions of points around points
  std::uint64_t entropy_points = 0;
  double mean_plane_variance_m2 = 0.0;  // smallest eigenvalue of NDs, by their points
  std::uint64_t plane_points = 0;
  friend bool operator==(const SharpnessFigures&, const SharpnessFigures&) = default;
};
SIGHTLINE_FIELDS(SharpnessFigures, mean_entropy_nat, entropy_points, mean_plane_variance_m2,
                 plane_points)

struct Sharpness {
  SharpnessFigures of_map;                   // with the trajectory that made the map
  std::optional<SharpnessFigures> of_given;  // the same scans with the poses given
  friend bool operator==(const Sharpness&, const Sharpness&) = default;
};
SIGHTLINE_FIELDS(Sharpness, of_map, of_given)
SIGHTLINE_ARTIFACT(Sharpness, "sharpness", 1)

Result<void> validate(const Sharpness& sharpness);
Table dump(const Sharpness& sharpness);

// One line for people.
std::string to_text(const Sharpness& sharpness);

}  // namespace sightline
