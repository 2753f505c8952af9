#include "formats/drive/localizer_profile.h"

#include <algorithm>

namespace sightline {
namespace {

constexpr std::size_t kLongestName = 64;

bool is_printable(std::string_view text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) { return c >= ' ' && c <= '~'; });
}

// Whether it has this parameter with this value.
bool has_parameter(const LocalizerProfile& profile,
                   const std::pair<std::string_view, std::string_view>& wanted) {
  return std::ranges::any_of(profile.parameters, [&](const auto& parameter) {
    return parameter.first == wanted.first && parameter.second == wanted.second;
  });
}

}  // namespace

bool is_localizer_name(std::string_view name) {
  return is_printable(name) && name.size() <= kLongestName &&
         name.find_first_of(" /") == std::string_view::npos;
}

Result<void> validate(const LocalizerProfile& profile) {
  if (!is_localizer_name(profile.name)) {
    return invalid_artifact(
        concat("found a name of ", profile.name.size(),
               " characters, expected 1 to 64 printable ones without a blank or '/'"),
        "localizer");
  }
  for (std::size_t i = 0; i < profile.parameters.size(); ++i) {
    const auto& [name, value] = profile.parameters[i];
    if (!is_printable(name) || !is_printable(value)) {
      return invalid_artifact(concat("parameter ", i, " is not printable ASCII"), "localizer");
    }
    if (i > 0 && profile.parameters[i - 1].first >= name) {
      return invalid_artifact(
          concat("the names of parameters must ascend, but do not at '", name, "'"), "localizer");
    }
  }
  return {};
}

bool took_every_return(const LocalizerProfile& profile) {
  return has_parameter(profile, kEveryReturn);
}

bool was_in_small_map(const LocalizerProfile& profile) { return has_parameter(profile, kSmallMap); }

std::string localizer_title(const LocalizerProfile& profile) {
  return concat(profile.name, " v", profile.version);
}

std::string parameters_text(const LocalizerProfile& profile) {
  std::string text;
  for (const auto& [name, value] : profile.parameters) {
    text += concat((text.empty() ? "" : ", "), name, "=", value);
  }
  return text;
}

std::string to_text(const LocalizerProfile& profile) {
  const std::string parameters = parameters_text(profile);
  return localizer_title(profile) + (parameters.empty() ? "" : concat(" (", parameters, ")"));
}

}  // namespace sightline
