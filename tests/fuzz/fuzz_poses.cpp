// Poses, stamps and errors of an outside localizer. The first byte decides which; the rest is the
// file.

#include "formats/foreign/text/outside_errors_file.h"
#include "formats/foreign/text/pose_file.h"
#include "tests/fuzz/fuzz.h"
#include "tests/support/test_files.h"

namespace sightline {
namespace {

void read_pose_file(const std::string& path, PoseFormat format) {
  const Result<std::vector<PoseRow>> rows = read_poses(path, format);
  if (!rows) return check_refusal(rows.error());
  for (std::size_t i = 0; i < rows->size(); ++i) {
    const PoseRow& row = (*rows)[i];
    const Eigen::Matrix3d R = row.T_world_vehicle.linear();
    SIGHTLINE_CHECK((R * R.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-9);
    SIGHTLINE_CHECK(row.T_world_vehicle.translation().allFinite());
    SIGHTLINE_CHECK(i == 0 || !row.stamp_ns || *(*rows)[i - 1].stamp_ns < *row.stamp_ns);
    if (row.stamp_ns) SIGHTLINE_CHECK(parse_stamp_ns(format_stamp(*row.stamp_ns)) == row.stamp_ns);
  }
}

void read_stamp_file(const std::string& path) {
  const Result<std::vector<std::int64_t>> stamps_ns = read_stamps(path);
  if (!stamps_ns) return check_refusal(stamps_ns.error());
  for (std::size_t i = 1; i < stamps_ns->size(); ++i) {
    SIGHTLINE_CHECK((*stamps_ns)[i - 1] < (*stamps_ns)[i]);
  }
}

void read_error_file(const std::string& path) {
  const Result<std::vector<OutsideError>> errors = read_outside_errors(path);
  if (!errors) return check_refusal(errors.error());
  SIGHTLINE_CHECK(!errors->empty());
}

}  // namespace
}  // namespace sightline

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sightline;
  if (size == 0) return 0;
  const MemoryFile file(std::as_bytes(std::span(data + 1, size - 1)));
  switch (data[0] % 6) {
    case 0:
      read_stamp_file(file.path());
      break;
    case 1:
      read_error_file(file.path());
      break;
    default:
      read_pose_file(file.path(), static_cast<PoseFormat>(data[0] % 6 - 2));
  }
  return 0;
}
