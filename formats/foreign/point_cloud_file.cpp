#include "formats/foreign/point_cloud_file.h"

#include <string>

#include "compiler/base/atomic_file.h"
#include "formats/foreign/cloud_parsers.h"
#include "formats/foreign/scan_files.h"

namespace sightline {
namespace {

// Files that people hand over as scans and that are none, known by their first bytes. At least four
// bytes each: a KITTI .bin begins with any float.
struct Stranger {
  std::string_view signature;
  ErrorCode code;
  std::string_view what;
};

constexpr std::string_view kLasSignature = "LASF";
constexpr Stranger kStrangers[] = {
    {"version https://git-lfs", ErrorCode::kGitLfsPointer,
     "a git-LFS pointer lies here instead of the scan; run `git lfs pull` where the recording was "
     "cloned"},
    {"ASTM-E57", ErrorCode::kUnsupportedFormat,
     "E57 is not read; convert it, for example with CloudCompare, to binary PCD"},
    {{"PK\x03\x04", 4}, ErrorCode::kUnsupportedFormat, "a zip archive; unpack it"},
    {"7z\xbc\xaf", ErrorCode::kUnsupportedFormat, "a 7z archive; unpack it"},
    {{"\xfd"
      "7zXZ",
      5},
     ErrorCode::kUnsupportedFormat,
     "xz-compressed; unpack it with `xz -d`"},
    {{"\x28\xb5\x2f\xfd", 4},
     ErrorCode::kUnsupportedFormat,
     "zstd-compressed; unpack it with `zstd -d`"},
    {{"\xd4\xc3\xb2\xa1", 4},
     ErrorCode::kUnsupportedFormat,
     "a pcap of sensor packets; export its scans as PCD with the sensor's own tools"},
    {{"\xa1\xb2\xc3\xd4", 4},
     ErrorCode::kUnsupportedFormat,
     "a pcap of sensor packets; export its scans as PCD with the sensor's own tools"},
    {"#ROSBAG", ErrorCode::kUnsupportedFormat,
     "a ROS bag; export its scans, for example with pcl_ros bag_to_pcd"},
    {"\x89MCAP", ErrorCode::kUnsupportedFormat, "an MCAP log; export its scans as PCD"},
    {"\x93NUMPY", ErrorCode::kUnsupportedFormat,
     "a numpy array; write its columns x y z intensity as float32 with tofile() to a .bin"},
};

bool is_gzip(std::string_view text) {
  return text.size() >= 4 && text.starts_with("\x1f\x8b\x08") &&
         static_cast<unsigned char>(text[3]) < 0x20;
}

Error las_error(const FileBytes& file) {
  // Bit 7 of the point format (byte 104 of the public header) says LAZ.
  constexpr std::size_t kPointFormat = 104;
  const bool compressed = file.bytes.size() > kPointFormat &&
                          (file.bytes[kPointFormat] & std::byte{0x80}) != std::byte{0};
  return file.error(ErrorCode::kUnsupportedFormat,
                    std::string(compressed ? "LAZ" : "LAS") +
                        " is not read; convert it, for example with `pdal translate in out.pcd`",
                    at_byte(0));
}

Result<void> refuse_strangers(const FileBytes& file) {
  const std::string_view text = file.text();
  for (const Stranger& stranger : kStrangers) {
    if (text.starts_with(stranger.signature)) {
      return file.error(stranger.code, std::string(stranger.what), at_byte(0));
    }
  }
  if (text.starts_with(kLasSignature)) return las_error(file);
  if (is_gzip(text)) {
    return file.error(ErrorCode::kUnsupportedFormat, "gzip-compressed; unpack it with `gunzip`",
                      at_byte(0));
  }
  return {};
}

Result<PointCloudFile> parse_by_kind(const FileBytes& file, const std::string& extension) {
  const std::string_view text = file.text();
  if (text.starts_with("ply\n") || text.starts_with("ply\r\n")) return parse_ply(file);
  if (text.starts_with("# .PCD") || extension == ".pcd") return parse_pcd(file);
  if (extension == ".ply") return parse_ply(file);
  if (extension == ".bin") return parse_kitti_bin(file);
  return file.error(ErrorCode::kUnsupportedFormat,
                    "found neither PCD, PLY nor KITTI .bin by name or content; convert the scan to "
                    "one of them",
                    at_byte(0));
}

}  // namespace

Result<PointCloudFile> parse_point_cloud(std::span<const std::byte> bytes,
                                         const std::filesystem::path& path) {
  const FileBytes file{bytes, path.string()};
  if (bytes.empty()) return file.error(ErrorCode::kEmptyScan, "the file is empty", at_byte(0));
  const Result<void> familiar = refuse_strangers(file);
  if (!familiar) return familiar.error();
  Result<PointCloudFile> cloud = parse_by_kind(file, lower_extension(path));
  if (cloud && cloud->points_m.empty()) {
    return file.error(ErrorCode::kNoFinitePoints,
                      "none of the points is a return: " + std::to_string(cloud->nonfinite_count) +
                          " are NaN or infinite, " + std::to_string(cloud->zero_count) +
                          " are (0,0,0)",
                      "");
  }
  return cloud;
}

Result<PointCloudFile> read_point_cloud(const std::filesystem::path& path) {
  const Result<std::vector<std::byte>> bytes = read_file(path);
  if (!bytes) return bytes.error();
  return parse_point_cloud(*bytes, path);
}

}  // namespace sightline
