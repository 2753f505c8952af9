#include "compiler/commands/judge/map_files.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <system_error>

#include "formats/reader/reader.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

Result<std::vector<std::string>> maps_in(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code failure;
  for (fs::directory_iterator entry(folder, failure), end; !failure && entry != end;
       entry.increment(failure)) {
    if (entry->path().extension() == ".slmap") files.push_back(entry->path().string());
  }
  if (failure) return Error{ErrorCode::kCannotRead, failure.message(), folder};
  if (files.empty()) {
    return Error{ErrorCode::kEmptyDirectory, "the folder contains no maps (.slmap)", folder};
  }
  std::ranges::sort(files);
  return files;
}

}  // namespace

Result<std::vector<std::string>> map_files(const std::vector<std::string>& named) {
  std::vector<std::string> files;
  for (const std::string& name : named) {
    std::error_code failure;
    std::vector<std::string> of_name = {name};
    if (fs::is_directory(name, failure)) {
      SIGHTLINE_ASSIGN(of_name, maps_in(name));
    }
    files.insert(files.end(), of_name.begin(), of_name.end());
  }
  return files;
}

Result<std::string> world_of(const std::vector<std::string>& map_files) {
  std::optional<Error> first;
  for (const std::string& file : map_files) {
    const Result<MapReader> map = MapReader::open(file, "");
    if (map) return std::string(map->info().world);
    if (!first) first = map.error();
  }
  return *first;
}

}  // namespace sightline
