#include "formats/foreign/maps/apollo_map.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <string>
#include <utility>

#include "formats/base/files/atomic_file.h"
#include "formats/base/parallel.h"
#include "formats/foreign/maps/apollo_files.h"
#include "formats/foreign/text/text_lines.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr const char* kConfig = "config.xml";
constexpr const char* kNodes = "map";
constexpr std::size_t kMostConfig = std::size_t{1} << 20U;
constexpr double kWanted_m = 2.0;  // cells of this length suit the localizer best

fs::path folder_of(const fs::path& path) {
  return path.filename() == kConfig ? path.parent_path() : path;
}

// A file of a node, and which one its folders say that it is.
struct NodeFile {
  fs::path file;
  ApolloNodeIndex index;
};

struct ApolloFiles {
  fs::path config_file;
  std::string config_text;
  ApolloConfig config;
  std::uint32_t resolution = 0;
  std::vector<NodeFile> nodes;  // ascending by zone, m and n
};

// Folders and files that a number names, in the order of their numbers.
Result<std::vector<std::pair<std::uint32_t, fs::path>>> numbered(const fs::path& folder) {
  std::error_code failure;
  std::vector<std::pair<std::uint32_t, fs::path>> found;
  for (fs::directory_iterator entry(folder, failure), end; !failure && entry != end;
       entry.increment(failure)) {
    const std::string name = entry->path().filename().string();
    const std::optional<std::uint32_t> number = to_number<std::uint32_t>(name);
    if (number && name.find_first_not_of("0123456789") == std::string::npos) {
      found.emplace_back(*number, entry->path());
    }
  }
  if (failure) {
    return Error{ErrorCode::kCannotRead, "cannot read the folder: " + failure.message(),
                 folder.string()};
  }
  std::ranges::sort(found);
  return found;
}

// Of one zone: a folder for each m, in it a file for each n.
Result<void> add_nodes(const fs::path& folder, ApolloNodeIndex index,
                       std::vector<NodeFile>& nodes) {
  SIGHTLINE_ASSIGN(const auto rows, numbered(folder));
  for (const auto& [m, row] : rows) {
    index.m = m;
    SIGHTLINE_ASSIGN(const auto files, numbered(row));
    for (const auto& [n, file] : files) {
      index.n = n;
      nodes.push_back({file, index});
    }
  }
  return {};
}

Result<std::vector<NodeFile>> nodes_of(const fs::path& folder, std::uint32_t resolution) {
  char name[16];
  std::snprintf(name, sizeof name, "%03u", resolution);
  std::vector<NodeFile> nodes;
  for (const char* half : {"north", "south"}) {
    const fs::path zones = folder / kNodes / name / half;
    std::error_code failure;
    if (!fs::is_directory(zones, failure)) continue;
    SIGHTLINE_ASSIGN(const auto found, numbered(zones));
    for (const auto& [zone, of_zone] : found) {
      constexpr std::uint32_t kMostZone = 60;
      if (zone < 1 || zone > kMostZone) {
        return Error{ErrorCode::kUnsupportedFormat,
                     concat("found zone ", zone, ", expected one of UTM, 1 to 60"),
                     of_zone.string()};
      }
      const auto number = static_cast<std::int32_t>(zone);
      SIGHTLINE_TRY(add_nodes(
          of_zone, {resolution, std::string_view(half) == "north" ? number : -number, 0, 0},
          nodes));
    }
  }
  if (!nodes.empty()) return nodes;
  return Error{ErrorCode::kEmptyDirectory,
               concat("found no node, expected files like ", kNodes, "/", name,
                      "/north/10/00032353/00004596"),
               folder.string()};
}

// The largest cells of at most kWanted_m; where there are none the finest.
std::uint32_t resolution_of(const ApolloConfig& config) {
  std::uint32_t best = 0;
  for (std::uint32_t i = 1; i < config.cells_m.size(); ++i) {
    const double found_m = config.cells_m[i];
    const double best_m = config.cells_m[best];
    const bool fits = found_m <= kWanted_m;
    const bool best_fits = best_m <= kWanted_m;
    if (fits ? !best_fits || found_m > best_m : !best_fits && found_m < best_m) best = i;
  }
  return best;
}

bool is_whole(double number) { return std::abs(number - std::round(number)) <= 1e-6; }

// Cubes that lie in a grid with the world's origin.
Result<void> check_grid(const ApolloFiles& files) {
  const double cell_m = files.config.cells_m[files.resolution];
  const double height_m = files.config.heights_m[files.resolution];
  if (cell_m != height_m) {
    return Error{
        ErrorCode::kUnsupportedFormat,
        concat("found cells of ", format_double(cell_m), " m, ", format_double(height_m),
               " m high, expected cubes; write the map with resolution_z equal to its resolution"),
        files.config_file.string()};
  }
  if (is_whole(files.config.min_x_m / cell_m) && is_whole(files.config.min_y_m / cell_m)) return {};
  return Error{ErrorCode::kUnsupportedFormat,
               concat("the map's range does not begin at a multiple of its cell of ",
                      format_double(cell_m), " m"),
               files.config_file.string()};
}

Result<ApolloFiles> find_files(const fs::path& path) {
  ApolloFiles files;
  const fs::path folder = folder_of(path);
  files.config_file = folder / kConfig;
  SIGHTLINE_ASSIGN(files.config_text, read_short_text(files.config_file, kMostConfig));
  SIGHTLINE_ASSIGN(files.config,
                   parse_apollo_config(files.config_text, files.config_file.string()));
  files.resolution = resolution_of(files.config);
  SIGHTLINE_TRY(check_grid(files));
  SIGHTLINE_ASSIGN(files.nodes, nodes_of(folder, files.resolution));
  const std::int32_t zone = files.nodes.front().index.zone;
  const auto is_elsewhere = [&](const NodeFile& node) { return node.index.zone != zone; };
  const auto other = std::ranges::find_if(files.nodes, is_elsewhere);
  if (other == files.nodes.end()) return files;
  return Error{ErrorCode::kUnsupportedFormat,
               concat("found nodes of two zones of UTM, ", zone, " and ", other->index.zone,
                      ", expected one plane"),
               folder.string()};
}

struct OpenedNode {
  ApolloNode node;
  Digest content{};
};

Result<OpenedNode> open_node(const NodeFile& file, const ApolloConfig& config) {
  SIGHTLINE_ASSIGN(const FileContent content, read_file_content(file.file));
  SIGHTLINE_ASSIGN(ApolloNode node,
                   parse_apollo_node(content.bytes(), config, file.index, file.file.string()));
  return OpenedNode{std::move(node), sha256(content.bytes())};
}

// Where two lie in one cell that of more points stays. Returns how many went.
std::size_t sort_once(std::vector<ForeignNd>& nds) {
  std::ranges::stable_sort(nds, [](const ForeignNd& a, const ForeignNd& b) {
    return a.key_world != b.key_world ? a.key_world < b.key_world : a.point_count > b.point_count;
  });
  const auto last = std::unique(nds.begin(), nds.end(), [](const ForeignNd& a, const ForeignNd& b) {
    return a.key_world == b.key_world;
  });
  const auto gone = static_cast<std::size_t>(nds.end() - last);
  nds.erase(last, nds.end());
  return gone;
}

void warn(const ApolloFiles& files, std::uint64_t damaged, std::size_t shared, ForeignNds& map) {
  const std::size_t resolutions = files.config.cells_m.size();
  if (resolutions > 1) {
    map.warnings.push_back(concat("has ", resolutions, " resolutions; its cells of ",
                                  format_double(map.cell_m), " m are used"));
  }
  if (damaged > 0) {
    map.warnings.push_back(concat(damaged,
                                  " cells with invalid numbers (not finite, outside their cell, or "
                                  "not a covariance) were left out"));
  }
  if (shared > 0) {
    map.warnings.push_back(concat(
        shared,
        " cells were left out, since a cell with more points has its mean in the same cell"));
  }
}

}  // namespace

bool is_apollo_map(const fs::path& path) {
  std::error_code failure;
  const fs::path folder = folder_of(path);
  return fs::is_regular_file(folder / kConfig, failure) &&
         fs::is_directory(folder / kNodes, failure);
}

Result<std::vector<fs::path>> list_apollo_map(const fs::path& path) {
  SIGHTLINE_ASSIGN(const ApolloFiles files, find_files(path));
  std::vector<fs::path> listed = {files.config_file};
  for (const NodeFile& node : files.nodes) listed.push_back(node.file);
  return listed;
}

Result<ForeignNds> open_apollo_map(const fs::path& path, int threads) {
  SIGHTLINE_ASSIGN(const ApolloFiles files, find_files(path));
  std::vector<std::optional<Result<OpenedNode>>> opened(files.nodes.size());
  parallel_for(files.nodes.size(), threads,
               [&](std::size_t i) { opened[i] = open_node(files.nodes[i], files.config); });
  ForeignNds map;
  const fs::path folder = folder_of(path);
  map.name = (folder.has_filename() ? folder : folder.parent_path()).filename().string();
  map.cell_m = files.config.cells_m[files.resolution];
  const std::int32_t zone = files.nodes.front().index.zone;
  map.world = concat("utm:", std::abs(zone), (zone > 0 ? "N" : "S"));
  DigestBuilder digest;
  digest.add("sightline map of Apollo's NDs");
  digest.add(files.config_text);
  std::uint64_t damaged = 0;
  for (std::size_t i = 0; i < opened.size(); ++i) {
    if (!*opened[i]) return opened[i]->error();
    const ApolloNode& node = (**opened[i]).node;
    map.nds.insert(map.nds.end(), node.nds.begin(), node.nds.end());
    map.single_point_count += node.single_point_count;
    map.point_count += node.point_count;
    damaged += node.damaged_count;
    digest.add(fs::relative(files.nodes[i].file, folder).generic_string());
    digest.add((**opened[i]).content);
  }
  warn(files, damaged, sort_once(map.nds), map);
  map.digest = digest.finish();
  return map;
}

}  // namespace sightline
