#include "formats/base/check.h"
#include "formats/foreign/logs/velodyne_packet.h"
#include "tests/fuzz/fuzz.h"
#include "tests/support/test_files.h"

namespace sightline {
namespace {

void check(const PointCloudFile& cloud) {
  SIGHTLINE_CHECK(cloud.intensity.size() == cloud.points_m.size());
  SIGHTLINE_CHECK(cloud.time_offset_ns.size() == cloud.points_m.size());
  for (const Eigen::Vector3d& point_m : cloud.points_m) SIGHTLINE_CHECK(point_m.allFinite());
}

}  // namespace
}  // namespace sightline

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sightline;
  const MemoryFile file(std::as_bytes(std::span(data, size)));
  const auto opened = open_velodyne_pcap(file.path());
  if (!opened) {
    SIGHTLINE_CHECK(error_class(opened.error().code) == ErrorClass::kInput);
    return 0;
  }
  const ScanContainer& container = **opened;
  SIGHTLINE_CHECK(!container.scans().empty());
  for (std::size_t i = 0; i < container.scans().size(); ++i) {
    const Result<std::vector<std::byte>> bytes = container.read(i);
    SIGHTLINE_CHECK(bytes.has_value());
    SIGHTLINE_CHECK(sha256(*bytes) == container.scans()[i].content);
    const Result<PointCloudFile> cloud = container.parse(*bytes, i);
    SIGHTLINE_CHECK(cloud.has_value());
    check(*cloud);
  }
  return 0;
}
