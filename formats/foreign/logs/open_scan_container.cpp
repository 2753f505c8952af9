#include "formats/foreign/logs/open_scan_container.h"

#include <array>
#include <fstream>

#include "formats/foreign/logs/pcap_reader.h"
#include "formats/foreign/logs/ros_bag.h"
#include "formats/foreign/logs/velodyne_pcap.h"

namespace sightline {
namespace {

// A file's first bytes; shorter where there are no more.
std::string signature_of(const std::filesystem::path& path) {
  std::array<char, 4> bytes{};
  std::ifstream file(path, std::ios::binary);
  file.read(bytes.data(), bytes.size());
  return {bytes.data(), static_cast<std::size_t>(file.gcount())};
}

}  // namespace

bool is_scan_container(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return false;
  return is_ros_bag(path) || is_pcap(signature_of(path));
}

Result<std::shared_ptr<const ScanContainer>> open_scan_container(const std::filesystem::path& path,
                                                                 const std::string& topic) {
  if (is_ros_bag(path)) return open_bag(path, topic);
  if (topic.empty()) return open_velodyne_pcap(path);
  return Error{ErrorCode::kBadValue, "a pcap has no topics, found topic '" + topic + "'",
               path.string(), ""};
}

}  // namespace sightline
