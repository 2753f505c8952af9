#include "formats/foreign/recording/open_scan_container.h"

#include "formats/base/files/regular_file.h"
#include "formats/foreign/logs/open_capture.h"
#include "formats/foreign/logs/pcap_reader.h"
#include "formats/foreign/ros/ros_bag.h"

namespace sightline {
namespace {

// A file's first bytes; shorter where there are no more.
std::string signature_of(const std::filesystem::path& path) {
  const Result<std::string> bytes = read_beginning(path.string(), 4);
  return bytes ? *bytes : std::string();
}

}  // namespace

bool is_scan_container(const std::filesystem::path& path) {
  if (is_ros_bag(path)) return true;
  std::error_code ignored;
  return std::filesystem::is_regular_file(path, ignored) && is_pcap(signature_of(path));
}

Result<std::shared_ptr<const ScanContainer>> open_scan_container(
    const std::filesystem::path& path, const std::string& topic,
    const std::filesystem::path& sensor) {
  if (is_ros_bag(path)) return open_bag(path, topic);
  if (topic.empty()) return open_capture(path, sensor);
  return Error{ErrorCode::kBadValue, "a pcap has no topics, found topic '" + topic + "'",
               path.string()};
}

}  // namespace sightline
