#include "formats/foreign/maps/foreign_maps.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "formats/base/files/atomic_file.h"
#include "formats/base/parallel.h"
#include "formats/foreign/clouds/read_point_cloud.h"
#include "formats/foreign/maps/coordinate_spacing.h"
#include "formats/foreign/recording/scan_files.h"
#include "formats/foreign/text/text_lines.h"
#include "formats/text/numbers.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMetadata = "pointcloud_map_metadata.yaml";
constexpr const char* kSquares = "pointcloud_map.pcd";

// The names of the squares: a line each, "name.pcd: [x, y]".
std::vector<std::string> squares_of(std::string_view text) {
  std::vector<std::string> names;
  LineReader lines(text);
  for (std::string_view line; lines.next(line);) {
    const std::size_t colon = line.rfind(':');
    if (colon == std::string_view::npos || line.find('[', colon) == std::string_view::npos) {
      continue;
    }
    const std::string_view name = trimmed(line.substr(0, colon), " \t\"'");
    if (!name.empty()) names.emplace_back(name);
  }
  std::ranges::sort(names, natural_less);
  return names;
}

// Where the metadata's squares lie. Errors: malformed-text, file-not-found.
Result<std::vector<fs::path>> listed_squares(const fs::path& metadata) {
  SIGHTLINE_ASSIGN(const std::string text, read_text_file(metadata));
  const std::vector<std::string> names = squares_of(text);
  if (names.empty()) {
    return Error{ErrorCode::kMalformedText,
                 "found no square, expected lines like \"0_0.pcd: [0, 0]\"", metadata.string()};
  }
  std::error_code failure;
  const fs::path beside = metadata.parent_path();
  std::vector<fs::path> files;
  for (const std::string& name : names) {
    const fs::path within = beside / kSquares / name;
    files.push_back(fs::is_regular_file(within, failure) ? within : beside / name);
    if (fs::is_regular_file(files.back(), failure)) continue;
    return Error{ErrorCode::kFileNotFound,
                 std::string(kMetadata) +
                     " lists this square, but its file is missing: the map would have a hole. "
                     "Restore the file or remove the line",
                 within.string()};
  }
  return files;
}

// Of a folder that holds a map.
Result<std::vector<fs::path>> files_of_folder(const fs::path& folder) {
  std::error_code failure;
  for (const fs::path& metadata : {folder / kMetadata, folder.parent_path() / kMetadata}) {
    const bool is_its_own = metadata.parent_path() == folder || folder.filename() == kSquares;
    if (is_its_own && fs::is_regular_file(metadata, failure)) return listed_squares(metadata);
  }
  return list_scan_files(folder);
}

struct OpenedFile {
  PointMapFile file;
  bool may_be_cut = false;
  CoordinateSpacing spacing;
};

std::string text_of(const CoordinateSpacing& spacing) {
  return concat("its coordinates have steps of ", format_double(spacing.spacing_m), " m near ",
                fixed(spacing.largest_m, 0),
                " m, as numbers of 32 bits (float32) or of few digits have. Export the map with "
                "numbers of 64 bits (double), or with an offset subtracted");
}

// Cells of 2 m need points at finer steps.
Result<void> check_spacing(const fs::path& path, const CoordinateSpacing& spacing) {
  constexpr double kMost_m = 0.1;
  if (spacing.spacing_m < kMost_m || !spacing.is_of_numbers()) return {};
  return Error{ErrorCode::kUnsupportedFormat, text_of(spacing), path.string()};
}

Result<OpenedFile> open_file(const fs::path& path) {
  SIGHTLINE_ASSIGN(const FileContent content, read_file_content(path));
  SIGHTLINE_ASSIGN(const PointCloudFile cloud, parse_point_cloud(content.bytes(), path));
  OpenedFile opened;
  PointMapFile& file = opened.file;
  file.file = path;
  file.name = path.filename().string();
  file.content = sha256(content.bytes());
  file.content_xxh3 = xxh3(content.bytes());
  file.point_count = cloud.points_m.size();
  file.dropped_count = cloud.nonfinite_count + cloud.zero_count + cloud.withheld_count;
  for (const Eigen::Vector3d& point_m : cloud.points_m) file.box_m.extend(point_m);
  opened.may_be_cut = cloud.may_be_cut;
  opened.spacing = coordinate_spacing(cloud.points_m);
  SIGHTLINE_TRY(check_spacing(path, opened.spacing));
  return opened;
}

Result<void> open_files(const std::vector<fs::path>& paths, int threads, PointMap& map) {
  std::vector<std::optional<Result<OpenedFile>>> opened(paths.size());
  parallel_for(paths.size(), threads, [&](std::size_t i) { opened[i] = open_file(paths[i]); });
  bool is_coarse = false;  // one warning for all
  for (const std::optional<Result<OpenedFile>>& file : opened) {
    if (!*file) return file->error();
    const OpenedFile& of = **file;
    map.files.push_back(of.file);
    constexpr double kCoarse_m = 0.02;
    if (of.spacing.spacing_m >= kCoarse_m && of.spacing.is_of_numbers() && !is_coarse) {
      map.warnings.push_back(concat(of.file.name, ": ", text_of(of.spacing)));
      is_coarse = true;
    }
    if (!of.may_be_cut) continue;
    map.warnings.push_back(concat("the last line of ", of.file.name,
                                  " has no line end: its last number may be cut off"));
  }
  return {};
}

// Points within a metre of each other are no map, but a town in degrees is.
Result<void> check_extent(const PointMap& map, const fs::path& path) {
  constexpr double kLeast_m = 1.0;
  Eigen::AlignedBox3d box_m;
  for (const PointMapFile& file : map.files) box_m.extend(file.box_m);
  const Eigen::Vector3d extent_m = box_m.sizes();
  if (extent_m.x() >= kLeast_m || extent_m.y() >= kLeast_m) return {};
  const bool may_be_degrees = box_m.max().head<2>().cwiseAbs().maxCoeff() <= 180.0 &&
                              box_m.min().head<2>().cwiseAbs().maxCoeff() <= 180.0;
  return Error{
      ErrorCode::kUnsupportedFormat,
      concat("the points span ", format_double(extent_m.x()), " by ", format_double(extent_m.y()),
             ", expected a map in metres",
             (may_be_degrees ? ". These look like degrees: project them first, for example to UTM"
                             : "")),
      path.string()};
}

Digest digest_of(const PointMap& map) {
  DigestBuilder builder;
  builder.add("sightline point map");
  for (const PointMapFile& file : map.files) {
    builder.add(file.name);
    builder.add(file.content);
  }
  return builder.finish();
}

class PointMapStore : public ScanStore {
 public:
  explicit PointMapStore(std::vector<PointMapFile> files) : files_(std::move(files)) {}
  [[nodiscard]] Result<Scan> read(std::size_t index) const override {
    const PointMapFile& file = files_.at(index);
    SIGHTLINE_ASSIGN(const FileContent content, read_file_content(file.file));
    if (xxh3(content.bytes()) != file.content_xxh3) {
      return Error{ErrorCode::kMismatchedInputs, "the file has changed since it was opened",
                   file.file.string()};
    }
    SIGHTLINE_ASSIGN(PointCloudFile cloud, parse_point_cloud(content.bytes(), file.file));
    Scan scan;
    scan.points_m = std::move(cloud.points_m);
    return scan;
  }
  [[nodiscard]] std::optional<Digest> identity(std::size_t index) const override {
    const PointMapFile& file = files_.at(index);
    const std::string extension = file.file.extension().string();
    return derived_digest("piece of a map", file.content, std::as_bytes(std::span(extension)));
  }
  [[nodiscard]] bool has_origins() const override { return false; }

 private:
  std::vector<PointMapFile> files_;
};

}  // namespace

Result<void> validate(const PointMap& map) {
  if (!map.files.empty()) return {};
  return Error{ErrorCode::kInvalidArtifact, "a map without files", "", map.name};
}

Table dump(const PointMap& map) {
  Table table{"point-map", {"file", "points", "dropped", "content_sha256"}, {}, {}};
  table.facts = {{"name", map.name}};
  for (const PointMapFile& file : map.files) {
    table.rows.push_back({file.name, static_cast<std::int64_t>(file.point_count),
                          static_cast<std::int64_t>(file.dropped_count), to_hex(file.content)});
  }
  return table;
}

Result<std::vector<fs::path>> list_point_map(const fs::path& path) {
  std::error_code failure;
  std::vector<fs::path> files = {path};
  if (fs::is_directory(path, failure)) {
    SIGHTLINE_ASSIGN(files, files_of_folder(path));
  }
  for (const fs::path& file : files) {
    if (!is_without_header(file)) continue;
    return Error{ErrorCode::kUnsupportedFormat,
                 "a .bin is a scan; a map is .pcd, .ply or .las, or a folder of them",
                 file.string()};
  }
  return files;
}

Result<PointMap> open_point_map(const fs::path& path, int threads) {
  SIGHTLINE_ASSIGN(const std::vector<fs::path> files, list_point_map(path));
  PointMap map;
  const fs::path plain = path.has_filename() ? path : path.parent_path();
  map.name = plain.filename() == kSquares ? plain.parent_path().filename().string()
                                          : plain.filename().string();
  SIGHTLINE_TRY(open_files(files, threads, map));
  SIGHTLINE_TRY(check_extent(map, path));
  map.digest = digest_of(map);
  return map;
}

std::shared_ptr<const ScanStore> point_map_store(const PointMap& map) {
  return std::make_shared<PointMapStore>(map.files);
}

Result<void> validate(const ForeignNds& map) {
  if (!(map.cell_m > 0.0)) {
    return Error{ErrorCode::kInvalidArtifact, "the size of a cell is not above 0 m", "", map.name};
  }
  for (std::size_t i = 0; i < map.nds.size(); ++i) {
    const ForeignNd& nd = map.nds[i];
    const bool is_inside =
        nd.mean_in_cell_m.minCoeff() >= 0.0 && nd.mean_in_cell_m.maxCoeff() < map.cell_m;
    const bool ascends = i == 0 || map.nds[i - 1].key_world < nd.key_world;
    if (is_inside && ascends && nd.point_count >= 2 && nd.covariance_m2.allFinite()) continue;
    return Error{ErrorCode::kInvalidArtifact,
                 "a mean outside its cell, a cell out of order or without 2 points, or a "
                 "covariance that is not finite",
                 "", concat("nd ", i)};
  }
  return {};
}

Table dump(const ForeignNds& map) {
  Table table{"foreign-nds", {"key_x", "key_y", "key_z", "point_count"}, {}, {}};
  for (const char axis : {'x', 'y', 'z'}) {
    table.columns.push_back(concat("mean_in_cell_", axis, "_m"));
  }
  table.facts = {{"name", map.name},
                 {"world", map.world},
                 {"cell_m", map.cell_m},
                 {"point_count", static_cast<std::int64_t>(map.point_count)},
                 {"single_point_count", static_cast<std::int64_t>(map.single_point_count)}};
  for (const ForeignNd& nd : map.nds) {
    table.rows.push_back({std::int64_t{nd.key_world.x}, std::int64_t{nd.key_world.y},
                          std::int64_t{nd.key_world.z}, std::int64_t{nd.point_count},
                          nd.mean_in_cell_m.x(), nd.mean_in_cell_m.y(), nd.mean_in_cell_m.z()});
  }
  return table;
}

}  // namespace sightline
