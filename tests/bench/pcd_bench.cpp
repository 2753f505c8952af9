#include <fcntl.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "formats/foreign/clouds/pcd_writer.h"
#include "formats/foreign/clouds/read_point_cloud.h"
#include "tests/bench/bench_clouds.h"
#include "tests/bench/pcl_peers.h"
#include "tests/bench/side_by_side.h"
#include "tests/support/real_data.h"

// Reading the scans of a drive from PCD files in the page cache, beside PCL's loader and beside
// reading their bytes into fresh memory, which is the bound. The files are a drawn scan, then
// the first ones of the set kitti_0005 (tests/README.md) where it is there.

namespace sightline {
namespace {

constexpr std::size_t kFiles = 16;

struct Files {
  std::vector<std::string> paths;
  std::size_t point_count = 0;
};

void count_points(Files& files) {
  for (const std::string& path : files.paths) {
    const Result<PointCloudFile> cloud = read_point_cloud(path);
    if (cloud) files.point_count += cloud->points_m.size();
  }
}

Files kitti_files(const std::string& folder) {
  Files files;
  for (std::size_t i = 0; i < kFiles; ++i) {
    char name[32];
    std::snprintf(name, sizeof name, "/%010zu.pcd", i);
    files.paths.push_back(folder + name);
  }
  count_points(files);
  return files;
}

Files drawn_files(const std::filesystem::path& folder) {
  std::vector<PointXyzi> points;
  for (const Eigen::Vector3d& point_m : street_scan_points()) {
    const Eigen::Vector3f position = point_m.cast<float>();
    points.push_back({position.x(), position.y(), position.z(), 0.5F});
  }
  Files files;
  for (std::size_t i = 0; i < kFiles; ++i) {
    files.paths.push_back(folder / (std::to_string(i) + ".pcd"));
    if (!write_pcd_binary(files.paths.back(), points, IfExists::kReplace)) return {};
  }
  count_points(files);
  return files;
}

std::vector<std::string> compressed_copies(const Files& files,
                                           const std::filesystem::path& folder) {
  std::vector<std::string> copies;
  for (std::size_t i = 0; i < files.paths.size(); ++i) {
    copies.push_back(folder / ("compressed_" + std::to_string(i) + ".pcd"));
    compress_with_pcl(files.paths[i], copies.back());
  }
  return copies;
}

void load(const std::vector<std::string>& paths) {
  for (const std::string& path : paths)
    if (!read_point_cloud(path)) std::abort();
}

void load_all_with_pcl(const std::vector<std::string>& paths) {
  for (const std::string& path : paths)
    if (load_with_pcl(path) == 0) std::abort();
}

void read_raw(const std::vector<std::string>& paths) {
  for (const std::string& path : paths) {
    const std::size_t size = std::filesystem::file_size(path);
    const std::unique_ptr<char[]> bytes(new char[size]);
    const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (::read(descriptor, bytes.get(), size) != static_cast<ssize_t>(size)) std::abort();
    ::close(descriptor);
  }
}

void compare_loads(const char* name, const Files& files, const std::filesystem::path& folder) {
  print_heading(std::string("PCD files of ") + name);
  constexpr int kRounds = 15;
  compare({"binary, peer: PCL", files.point_count, kRounds, [&] { load(files.paths); },
           [&] { load_all_with_pcl(files.paths); }});
  compare({"binary, peer: read() alone", files.point_count, kRounds, [&] { load(files.paths); },
           [&] { read_raw(files.paths); }});
  const std::vector<std::string> copies = compressed_copies(files, folder);
  compare({"binary_compressed, peer: PCL", files.point_count, kRounds, [&] { load(copies); },
           [&] { load_all_with_pcl(copies); }});
}

}  // namespace
}  // namespace sightline

int main() {
  using namespace sightline;
  const std::filesystem::path folder = std::filesystem::temp_directory_path() /
                                       ("sightline_pcd_bench_" + std::to_string(::getpid()));
  std::filesystem::create_directory(folder);
  compare_loads("a drawn street", drawn_files(folder), folder);
  const RealData kitti = real_data("kitti_0005");
  if (kitti.missing.empty()) {
    compare_loads("kitti_0005", kitti_files(kitti.folder), folder);
  } else {
    std::fprintf(stderr, "%s\n", kitti.missing.c_str());
  }
  std::filesystem::remove_all(folder);
}
