// A delta from anywhere, applied to a small map: it is refused and the map stays, or what comes of
// it is the map that it names, whole.

#include <fcntl.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include "formats/base/check.h"
#include "formats/base/files/atomic_file.h"
#include "formats/map/delta/apply_delta.h"
#include "formats/map/delta/delta_format.h"
#include "formats/map/delta/make_delta.h"
#include "formats/map/delta/map_digest_check.h"
#include "formats/map/map_writer.h"
#include "tests/fuzz/delta_base.h"
#include "tests/fuzz/fuzz.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::byte>;

void write(const fs::path& path, std::span<const std::byte> bytes) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

struct Bench {
  Bench() {
    folder = fs::path("/dev/shm") / ("fuzz_delta_" + std::to_string(::getpid()));
    fs::create_directories(folder);
    map = folder / "map.slmap";
    delta = folder / "input.sldelta";
    base = encode_map(fuzzed_base());
    write(map, base);
  }
  ~Bench() { fs::remove_all(folder); }
  fs::path folder;
  fs::path map;
  fs::path delta;
  Bytes base;
};

Bench& bench() {
  static Bench the_bench;
  return the_bench;
}

template <class T>
void store(std::span<std::byte> bytes, std::size_t offset, T value) {
  std::memcpy(bytes.data() + offset, &value, sizeof value);
}

// Where the header has its fields: schemas/delta_format.md.
constexpr std::size_t kFileSize = 32;
constexpr std::size_t kBaseSize = 40;
constexpr std::size_t kBaseRoot = 48;
constexpr std::size_t kBaseChecksum = 80;
constexpr std::size_t kStepCount = 160;
constexpr std::size_t kStepsChecksum = 168;

// Names the map that is there, whatever zstd and format packed it, and seals the header.
void name_base(std::span<std::byte> file) {
  const Result<MapIdentity> base = identity_of(bench().base);
  SIGHTLINE_CHECK(base.has_value());
  store(file, kBaseSize, base->size);
  std::memcpy(file.data() + kBaseRoot, base->root_digest.data(), base->root_digest.size());
  store(file, kBaseChecksum, base->header_checksum);
  store(file, kDeltaHeaderSize - 8, xxh3(file.first(kDeltaHeaderSize - 8)));
}

// Sizes and checksums fit the bytes again, so that the fuzzer reaches what lies behind them.
void repair(std::span<std::byte> file) {
  if (file.size() < kDeltaHeaderSize) return;
  std::uint64_t count = 0;
  std::memcpy(&count, file.data() + kStepCount, sizeof count);
  count = std::min<std::uint64_t>(count, (file.size() - kDeltaHeaderSize) / kDeltaStepSize);
  store(file, kStepCount, count);
  std::uint64_t payload = kDeltaHeaderSize + count * kDeltaStepSize;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::span<std::byte> step = file.subspan(kDeltaHeaderSize + i * kDeltaStepSize);
    std::uint64_t size = 0;
    std::memcpy(&size, step.data() + 32, sizeof size);
    if (size == 0 || size > file.size() - payload) continue;
    store(step, 40, xxh3(file.subspan(payload, size)));
    payload += size;
  }
  store(file, kStepsChecksum, xxh3(file.subspan(kDeltaHeaderSize, count * kDeltaStepSize)));
  store(file, kFileSize, std::uint64_t{file.size()});
  name_base(file);
}

}  // namespace
}  // namespace sightline

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned int seed) {
  using namespace sightline;
  if (seed % 8 == 0) {
    size = LLVMFuzzerMutate(data, size, max_size);
  } else {
    mutate_in_place(std::as_writable_bytes(std::span(data, size)));
  }
  if (seed % 16 != 1) repair(std::as_writable_bytes(std::span(data, size)));
  return size;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sightline;
  const std::span<const std::byte> input = std::as_bytes(std::span(data, size));
  Bytes delta(input.begin(), input.end());
  if (decode_delta_header(delta, delta.size())) name_base(delta);
  write(bench().delta, delta);
  const Result<ApplyReport> report = apply_delta(bench().delta, bench().map);
  const Result<Bytes> map = read_file(bench().map);
  SIGHTLINE_CHECK(map.has_value());
  if (!report) {
    SIGHTLINE_CHECK(*map == bench().base);
    return 0;
  }
  const Result<Digest> root = check_map_digests(bench().map);
  SIGHTLINE_CHECK(root.has_value() && *root == report->root_digest);
  write(bench().map, bench().base);
  return 0;
}
