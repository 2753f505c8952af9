#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/base/result.h"
#include "formats/record/fields.h"

namespace sightline {

// A localizer whose errors were measured: what a map predicts holds for it and for no other.
struct LocalizerProfile {
  // As a vehicle names its own to the reader. Of this program's: "plain", "annealed", "searching",
  // "pcl-ndt"; any other is of a localizer outside, named by the user who imported its errors.
  std::string name = "searching";
  std::uint32_t version = 3;  // of its definition: of ours "Localizers" in schemas/definitions.md
  // What the name leaves open, with units in the names: {"leaf_m", "1"}; ascending names.
  std::vector<std::pair<std::string, std::string>> parameters;
  friend bool operator==(const LocalizerProfile&, const LocalizerProfile&) = default;
};
SIGHTLINE_FIELDS(LocalizerProfile, name, version, parameters)

// 1 to 64 printable characters of ASCII without a blank or '/', which stands before a version.
bool is_localizer_name(std::string_view name);

// A name as above, and ascending parameters that are printable ASCII. Error: invalid-artifact.
Result<void> validate(const LocalizerProfile& profile);

// Whether it took every return within a range, as its parameters say.
bool took_every_return(const LocalizerProfile& profile);
inline constexpr std::pair<std::string_view, std::string_view> kEveryReturn = {"returns", "every"};

// Whether it localized in a small map ("Small maps" in schemas/definitions.md), as they say.
bool was_in_small_map(const LocalizerProfile& profile);
inline constexpr std::pair<std::string_view, std::string_view> kSmallMap = {"map", "promise"};

// "searching v3"
std::string localizer_title(const LocalizerProfile& profile);
// "coarse_cells=1, leaf_m=1"; empty where there is none.
std::string parameters_text(const LocalizerProfile& profile);
// Both: "searching v3 (coarse_cells=1, leaf_m=1)".
std::string to_text(const LocalizerProfile& profile);

}  // namespace sightline
