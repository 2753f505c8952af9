#include "formats/foreign/clouds/read_point_cloud.h"

#include <algorithm>
#include <array>

#include "formats/base/files/atomic_file.h"
#include "formats/foreign/clouds/cloud_parsers.h"
#include "formats/foreign/text/file_bytes.h"

namespace sightline {
namespace {

// Files that people hand over as scans and that are none, known by their first bytes. At least four
// bytes each: a KITTI .bin begins with any float.
struct RefusedKind {
  std::string_view mark;  // the first bytes, or the ending of the name
  std::string_view what;
};

constexpr RefusedKind kRefusedSignatures[] = {
    {"ASTM-E57", "E57 is not read; convert it, for example with CloudCompare, to binary PCD"},
    {"PK\x03\x04", "a zip archive; unpack it"},
    {"7z\xbc\xaf", "a 7z archive; unpack it"},
    {"\3757zXZ", "xz-compressed; unpack it with `xz -d`"},
    {"\x28\xb5\x2f\xfd", "zstd-compressed; unpack it with `zstd -d`"},
    {"\xd4\xc3\xb2\xa1", "a pcap holds many scans; name the file itself as `scans`"},
    {"\x4d\x3c\xb2\xa1", "a pcap holds many scans; name the file itself as `scans`"},
    {"\x0a\x0d\x0d\x0a", "a pcapng holds many scans; name the file itself as `scans`"},
    {"#ROSBAG", "a ROS bag holds many scans; name the file itself as `scans`"},
    {"\x89MCAP", "an MCAP file holds many scans; name the file itself as `scans`"},
    {"SQLite format 3", "a .db3 of ROS 2 holds many scans; name the file itself as `scans`"},
    {"# vtk DataFile",
     "VTK is not read; convert it, for example with `pcl_vtk2pcd in.vtk out.pcd`"},
    {"solid ",
     "an STL file is a mesh, not a scan; sample its surface to points, for example with "
     "CloudCompare"},
    {"<?xml",
     "XML (Collada, X3D, ...) is not read; sample the model to points and save them as PCD"},
};

// Files without a signature, known by their names.
constexpr std::string_view kNotAScan =
    "the file is a mesh, not a scan; sample its surface to points, for example with CloudCompare";
constexpr std::string_view kColumns =
    "text without a header is not read; give it a PCD header (FIELDS x y z, DATA ascii), for "
    "example with CloudCompare";
constexpr std::string_view kArchive = "a tar archive; unpack it with `tar -xf`";
constexpr std::string_view kLivoxFile =
    "Livox's LVX is not read; convert it to a bag with livox_ros_driver (`roslaunch "
    "livox_ros_driver lvx_to_rosbag.launch lvx_file_path:=in.lvx`), or to LAS with Livox Viewer";
constexpr RefusedKind kRefusedEndings[] = {
    {".obj", kNotAScan},
    {".off", kNotAScan},
    {".stl", kNotAScan},
    {".xyz", kColumns},
    {".txt", kColumns},
    {".csv", kColumns},
    {".asc", kColumns},
    {".pts", kColumns},
    {".json", "JSON is not read; save the points as PCD"},
    {".osf", "Ouster's OSF is not read; convert it with `ouster-cli source in.osf save out.pcap`"},
    {".tar", kArchive},
    {".tgz", kArchive},
    {".lvx", kLivoxFile},
    {".lvx2", kLivoxFile},
};

// The formats that are read. All texts that name them are made from these endings.
struct CloudKind {
  std::string_view ending;
  std::array<std::string_view, 2> signatures;  // the file begins with one of them; empty: none
  bool is_known_by_ending;                     // where the file begins with no signature
  // Null: floats, which are read by columns that are given or found.
  Result<PointCloudFile> (*parse)(const FileBytes& file);
};

constexpr CloudKind kKinds[] = {
    {".pcd", {"# .PCD"}, true, parse_pcd}, {".ply", {"ply\n", "ply\r\n"}, true, parse_ply},
    {".las", {"LASF"}, false, parse_las},  {".npy", {kNpySignature}, false, parse_npy},
    {".bin", {}, true, nullptr},
};

bool begins_as(const CloudKind& kind, std::string_view text) {
  return std::ranges::any_of(kind.signatures, [&](std::string_view signature) {
    return !signature.empty() && text.starts_with(signature);
  });
}

Result<void> refuse_unsupported_formats(const FileBytes& file) {
  const std::string_view text = file.text();
  if (text.starts_with("version https://git-lfs")) {
    return file.error(ErrorCode::kGitLfsPointer,
                      "the file is a git-LFS pointer, not the scan; run `git lfs pull` where the "
                      "recording was cloned",
                      at_byte(0));
  }
  for (const RefusedKind& kind : kRefusedSignatures) {
    if (!text.starts_with(kind.mark)) continue;
    return file.error(ErrorCode::kUnsupportedFormat, std::string(kind.what), at_byte(0));
  }
  return {};
}

Result<PointCloudFile> parse_by_kind(const FileBytes& file, const std::string& extension,
                                     const std::optional<FloatColumns>& columns) {
  for (const CloudKind& kind : kKinds) {
    if (begins_as(kind, file.text())) return kind.parse(file);
  }
  for (const CloudKind& kind : kKinds) {
    if (!kind.is_known_by_ending || extension != kind.ending) continue;
    return kind.parse != nullptr ? kind.parse(file) : parse_float_bin(file, columns);
  }
  for (const RefusedKind& kind : kRefusedEndings) {
    if (extension != kind.mark) continue;
    return file.error(ErrorCode::kUnsupportedFormat, std::string(kind.what), at_byte(0));
  }
  return file.error(ErrorCode::kUnsupportedFormat,
                    concat("neither its name nor its content is that of a ", scan_endings_text(),
                           "; convert the scan to one of these"),
                    at_byte(0));
}

constexpr std::string_view kGzipEnding = ".gz";

// "drive/0.bin" of "drive/0.bin.gz".
std::filesystem::path without_gz(std::filesystem::path path) {
  if (lower_extension(path) == kGzipEnding) path.replace_extension();
  return path;
}

// Calls body(file) with the file itself, or with what a gzip holds under the name that it had.
// Once: a gzip in a gzip has neither the name nor the signature of a scan. Errors name the file
// itself.
template <class T, class Body>
Result<T> unpacked(const FileBytes& file, Body body) {
  if (!is_gzip(file.text())) return body(file);
  SIGHTLINE_ASSIGN(const std::vector<std::byte> bytes, unpack_gzip(file));
  Result<T> made = body(FileBytes{bytes, without_gz(file.file).string()});
  if (made) return made;
  Error error = made.error();
  error.file = file.file;
  return error;
}

FloatEvidence evidence_of(const FileBytes& file, const std::optional<FloatColumns>& believed) {
  FloatEvidence evidence;
  const bool says_it_itself = std::ranges::any_of(
      kKinds, [&](const CloudKind& kind) { return begins_as(kind, file.text()); });
  if (says_it_itself) return evidence;
  evidence.dividing = dividing_counts(file.bytes.size());
  if (believed) {
    evidence.refutes = is_refuted(file.bytes, believed->count);
  } else {
    evidence.fitting = fitting_counts(file);
  }
  return evidence;
}

Result<PointCloudFile> parse_unpacked(const FileBytes& file,
                                      const std::optional<FloatColumns>& columns) {
  if (file.bytes.empty()) {
    return file.error(ErrorCode::kEmptyScan, "the file is empty", at_byte(0));
  }
  SIGHTLINE_TRY(refuse_unsupported_formats(file));
  Result<PointCloudFile> cloud = parse_by_kind(file, lower_extension(file.file), columns);
  if (!cloud) return cloud.error();
  return with_returns(*std::move(cloud), file.file, "");
}

}  // namespace

bool is_scan_ending(std::string_view extension) {
  return extension == kGzipEnding || std::ranges::any_of(kKinds, [&](const CloudKind& kind) {
           return extension == kind.ending;
         });
}

std::string scan_endings_text() {
  std::string text(kKinds[0].ending);
  for (std::size_t i = 1; i < std::size(kKinds); ++i) {
    text += i + 1 < std::size(kKinds) ? ", " : " or ";
    text += kKinds[i].ending;
  }
  return text;
}

Result<PointCloudFile> with_returns(PointCloudFile cloud, const std::string& file,
                                    const std::string& place) {
  if (!cloud.points_m.empty()) return cloud;
  return Error{
      ErrorCode::kNoFinitePoints,
      concat("none of the points is a return: ", cloud.nonfinite_count, " are NaN or infinite, ",
             cloud.zero_count, " are (0,0,0), ", cloud.withheld_count, " are withheld"),
      file, place};
}

bool is_without_header(const std::filesystem::path& path) {
  return lower_extension(without_gz(path)) == ".bin";
}

Result<PointCloudFile> parse_point_cloud(std::span<const std::byte> bytes,
                                         const std::filesystem::path& path,
                                         const std::optional<FloatColumns>& columns) {
  return unpacked<PointCloudFile>(
      {bytes, path.string()}, [&](const FileBytes& file) { return parse_unpacked(file, columns); });
}

Result<PointCloudFile> read_point_cloud(const std::filesystem::path& path,
                                        const std::optional<FloatColumns>& columns) {
  SIGHTLINE_ASSIGN(const FileContent content, read_file_content(path));
  return parse_point_cloud(content.bytes(), path, columns);
}

Result<FloatEvidence> float_evidence(std::span<const std::byte> bytes,
                                     const std::filesystem::path& path,
                                     const std::optional<FloatColumns>& believed) {
  return unpacked<FloatEvidence>(
      {bytes, path.string()},
      [&](const FileBytes& file) -> Result<FloatEvidence> { return evidence_of(file, believed); });
}

}  // namespace sightline
