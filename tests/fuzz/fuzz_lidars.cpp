// Captures of Ouster's and Hesai's sensors: every scan. The first byte decides whose; then what
// lies beside the capture (Ouster's metadata, Hesai's angle correction), behind its length in 32
// bits; the rest is the capture.

#include <algorithm>
#include <cstring>

#include "formats/foreign/logs/hesai_lidar.h"
#include "formats/foreign/logs/open_capture.h"
#include "formats/foreign/logs/pcap_reader.h"
#include "formats/foreign/logs/rotating_pcap.h"
#include "tests/fuzz/fuzz.h"
#include "tests/support/test_files.h"

namespace sightline {
namespace {

void check(const Error& error) {
  check_refusal(error, {ErrorCode::kTooLarge}, /*may_be_usage=*/true);
}

using Opened = Result<std::shared_ptr<const ScanContainer>>;

Opened open_hesai(const std::string& path, const std::string& beside) {
  SIGHTLINE_ASSIGN(PcapReader reader, PcapReader::open(path));
  PcapPacket packet;
  while (true) {
    SIGHTLINE_ASSIGN(const bool more, reader.next(packet));
    if (!more) return Error{ErrorCode::kDriveTooShort, "no packet", path};
    if (is_hesai_packet(packet.datagram)) break;
  }
  SIGHTLINE_ASSIGN(std::unique_ptr<const RotatingLidar> lidar,
                   hesai_lidar(packet.datagram, beside));
  return open_rotating_pcap(path, std::move(lidar));
}

void check(const ScanContainer& container) {
  SIGHTLINE_CHECK(!container.scans().empty());
  for (std::size_t i = 0; i < container.scans().size(); ++i) {
    SIGHTLINE_CHECK(i == 0 || container.scans()[i - 1].stamp_ns <= container.scans()[i].stamp_ns);
    const Result<std::vector<std::byte>> bytes = container.read(i);
    SIGHTLINE_CHECK(bytes.has_value());
    SIGHTLINE_CHECK(sha256(*bytes) == container.scans()[i].content);
    const Result<PointCloudFile> cloud = container.parse(*bytes, i);
    SIGHTLINE_CHECK(cloud.has_value());
    SIGHTLINE_CHECK(cloud->intensity.size() == cloud->points_m.size());
    SIGHTLINE_CHECK(cloud->time_offset_ns.size() == cloud->points_m.size());
    for (const Eigen::Vector3d& point_m : cloud->points_m) SIGHTLINE_CHECK(point_m.allFinite());
  }
}

}  // namespace
}  // namespace sightline

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sightline;
  constexpr std::size_t kHead = 5;
  if (size < kHead) return 0;
  std::uint32_t length = 0;
  std::memcpy(&length, data + 1, sizeof length);
  const std::size_t beside_size = std::min<std::size_t>(length, size - kHead);
  const std::span<const std::byte> rest = std::as_bytes(std::span(data + kHead, size - kHead));
  const MemoryFile beside(rest.first(beside_size));
  const MemoryFile capture(rest.subspan(beside_size));
  const unsigned kind = data[0] % 3U;
  const Opened opened = kind == 0 ? open_ouster_pcap(capture.path(), beside.path())
                        : kind == 1
                            ? open_hesai(capture.path(), beside_size > 0 ? beside.path() : "")
                            : open_capture(capture.path(), "");
  if (opened) {
    check(**opened);
  } else {
    check(opened.error());
  }
  return 0;
}
