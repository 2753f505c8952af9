// A point cloud file as a stranger's program wrote it. The first byte decides what its name says of
// it; the rest is the file.

#include <zlib.h>

#include <array>

#include "formats/foreign/clouds/cloud_parsers.h"
#include "formats/foreign/clouds/point_cloud_file.h"
#include "formats/foreign/clouds/read_point_cloud.h"
#include "formats/foreign/text/file_bytes.h"
#include "tests/fuzz/fuzz.h"

namespace sightline {
namespace {

void check(const Error& error) { check_refusal(error, {ErrorCode::kOutOfMemory}); }

constexpr std::array<const char*, 7> kNames = {"a.pcd",     "a.ply",    "a.las",   "a.bin",
                                               "a.pcd.bin", "a.pcd.gz", "a.bin.gz"};

void check(const PointCloudFile& cloud) {
  SIGHTLINE_CHECK(!cloud.points_m.empty());
  SIGHTLINE_CHECK(cloud.intensity.size() == cloud.points_m.size());
  const bool has_times = !cloud.time_offset_ns.empty();
  SIGHTLINE_CHECK(!has_times || cloud.time_offset_ns.size() == cloud.points_m.size());
  for (const Eigen::Vector3d& point_m : cloud.points_m) {
    SIGHTLINE_CHECK(point_m.allFinite() && !point_m.isZero(0.0));
  }
}

std::vector<std::byte> packed(std::span<const std::byte> bytes) {
  z_stream stream{};
  constexpr int kGzipWindow = 15 + 16;
  SIGHTLINE_CHECK(deflateInit2(&stream, 0, Z_DEFLATED, kGzipWindow, 1, Z_DEFAULT_STRATEGY) == Z_OK);
  std::vector<std::byte> member(deflateBound(&stream, bytes.size()));
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(member.data());
  stream.avail_out = static_cast<uInt>(member.size());
  SIGHTLINE_CHECK(deflate(&stream, Z_FINISH) == Z_STREAM_END);
  member.resize(stream.total_out);
  deflateEnd(&stream);
  return member;
}

}  // namespace
}  // namespace sightline

// Mutates what a gzip holds, too: blind changes of one end at its checksum.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned int seed) {
  using namespace sightline;
  constexpr std::size_t kMostHeld = 1U << 16U;
  const auto bytes = std::as_bytes(std::span(data, size));
  const FileBytes file{size == 0 ? bytes : bytes.subspan(1), "a.gz"};
  if (seed % 8 == 0 || !is_gzip(file.text())) return LLVMFuzzerMutate(data, size, max_size);
  Result<std::vector<std::byte>> held = unpack_gzip(file);
  if (!held || held->size() > kMostHeld) return LLVMFuzzerMutate(data, size, max_size);
  const std::size_t old_size = held->size();
  held->resize(old_size + 64);
  held->resize(
      LLVMFuzzerMutate(reinterpret_cast<std::uint8_t*>(held->data()), old_size, held->size()));
  std::vector<std::byte> made = packed(*held);
  made.insert(made.begin(), bytes.front());
  return hand_back(made, data, size, max_size);
}

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
