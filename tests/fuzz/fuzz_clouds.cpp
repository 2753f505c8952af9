// A point cloud file as a stranger's program wrote it. The first byte tells what its name says of
// it; the rest is the file.

#include <array>
#include <string>

#include "formats/base/check.h"
#include "formats/foreign/clouds/read_point_cloud.h"
#include "tests/fuzz/fuzz.h"

namespace sightline {
namespace {

constexpr std::array<const char*, 6> kNames = {"a.pcd", "a.ply",     "a.las",
                                               "a.bin", "a.pcd.bin", "a.pcd.gz"};

// Whatever is read is one thing a point, and all of it finite.
void check(const PointCloudFile& cloud) {
  SIGHTLINE_CHECK(!cloud.points_m.empty());
  SIGHTLINE_CHECK(cloud.intensity.size() == cloud.points_m.size());
  const bool has_times = !cloud.time_offset_ns.empty();
  SIGHTLINE_CHECK(!has_times || cloud.time_offset_ns.size() == cloud.points_m.size());
  for (const Eigen::Vector3d& point_m : cloud.points_m) {
    SIGHTLINE_CHECK(point_m.allFinite() && !point_m.isZero(0.0));
  }
}

void check(const Error& error) {
  SIGHTLINE_CHECK(error_class(error.code) == ErrorClass::kInput ||
                  error.code == ErrorCode::kOutOfMemory);
  SIGHTLINE_CHECK(!error.message.empty());
}

}  // namespace
}  // namespace sightline

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sightline;
  if (size == 0) return 0;
  const FuzzInput input(data + 1, size - 1);
  const char* name = kNames[data[0] % kNames.size()];
  for (const std::optional<FloatColumns>& columns :
       {std::optional<FloatColumns>(), {FloatColumns()}}) {
    const Result<PointCloudFile> cloud = parse_point_cloud(input.bytes(), name, columns);
    if (cloud) {
      check(*cloud);
    } else {
      check(cloud.error());
    }
    const Result<FloatEvidence> evidence = float_evidence(input.bytes(), name, columns);
    if (!evidence) check(evidence.error());
  }
  return 0;
}
