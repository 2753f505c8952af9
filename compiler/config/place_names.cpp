#include "compiler/config/place_names.h"

#include <algorithm>
#include <filesystem>

namespace sightline {
namespace {

namespace fs = std::filesystem;

fs::path common_folder(const fs::path& a, const fs::path& b) {
  const auto end = std::mismatch(a.begin(), a.end(), b.begin(), b.end()).first;
  fs::path common;
  for (auto part = a.begin(); part != end; ++part) common /= *part;
  return common;
}

}  // namespace

std::vector<std::string> place_names(const std::vector<std::string>& files) {
  std::vector<fs::path> paths;
  for (const std::string& file : files) paths.push_back(fs::absolute(file).lexically_normal());
  fs::path common = paths.empty() ? fs::path() : paths.front().parent_path();
  for (const fs::path& path : paths) common = common_folder(common, path.parent_path());
  std::vector<std::string> names;
  for (const fs::path& path : paths) {
    names.push_back(path.lexically_relative(common).generic_string());
  }
  return names;
}

}  // namespace sightline
