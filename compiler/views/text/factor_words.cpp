#include "compiler/views/text/factor_words.h"

#include <algorithm>

namespace sightline {
namespace {

struct FactorWords {
  std::string_view name;
  std::string_view words;
};

constexpr FactorWords kWords[] = {
    {"feature_count", "number of NDs"},
    {"d1_count", "number of lines"},
    {"d2_count", "number of planes"},
    {"d3_count", "number of volumes"},
    {"d1_ratio", "share of lines"},
    {"d2_ratio", "share of planes"},
    {"d3_ratio", "share of volumes"},
    {"occupancy_ratio", "share of directions with a surface"},
    {"normal_entropy", "variety of plane directions (bits)"},
    {"r_average", "mean distance of NDs (m)"},
    {"score_entropy", "spread of the match score around the place (bits)"},
    {"crlb_max", "bound of the error in the weakest direction (m)"},
    {"crlb_min", "bound of the error in the strongest direction (m)"},
    {"crlb_heading", "weakest direction (degrees from +x)"},
    {"crlb_yaw", "bound of the heading error (rad)"},
    {"hz_lmin", "constraint by planes in the weakest direction"},
    {"flat_050", "match score 0.5 m off, relative to the place"},
    {"virtual_points", "points of a virtual scan"},
    {"virtual_error", "error of virtual scans (m)"},
    {"rival_score", "best match score 0.5 to 2.5 m off, relative to the place"},
    {"own_error", "error of the map's own scans against the reference (m)"},
    {"mapping_error", "error of the map's own scans against their mapped pose (m)"},
};

}  // namespace

std::string factor_words(std::string_view name) {
  const auto* const found = std::ranges::find(kWords, name, &FactorWords::name);
  return std::string(found == std::end(kWords) ? name : found->words);
}

}  // namespace sightline
