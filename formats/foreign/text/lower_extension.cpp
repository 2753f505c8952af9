#include "formats/foreign/text/lower_extension.h"

#include <algorithm>
#include <cctype>

namespace sightline {

std::string lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

}  // namespace sightline
