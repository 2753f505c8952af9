// A map from anywhere: whatever its bytes, every reader refuses it or keeps its promises.

#include <algorithm>
#include <cmath>

#include "formats/base/check.h"
#include "formats/map/compiled_map.h"
#include "formats/map/map_reader.h"
#include "formats/map/map_writer.h"
#include "formats/reader/map_layout.h"
#include "formats/reader/reader.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/repair_map.h"

namespace sightline {
namespace {

void check_answer(const MapReader& reader, const RangeAnswer& answer) {
  const std::span<const double> ranges = reader.info().ranges_m;
  SIGHTLINE_CHECK(std::find(ranges.begin(), ranges.end(), answer.range_m) != ranges.end());
  const bool is_unknown = (answer.flags & kAnswerUnknownLocalizer) != 0;
  SIGHTLINE_CHECK(is_unknown == std::isnan(answer.probability));
  SIGHTLINE_CHECK(is_unknown || (answer.probability >= 0.0 && answer.probability <= 1.0));
  const bool is_far = (answer.flags & kAnswerFar) != 0;
  SIGHTLINE_CHECK(!is_far || answer.range_m == ranges.back());
  SIGHTLINE_CHECK(is_far || answer.site < reader.info().site_count);
}

void check_look(const MapReader& reader, const LookAnswer& answer) {
  const bool is_unknown = (answer.flags & kAnswerUnknownLocalizer) != 0;
  SIGHTLINE_CHECK(is_unknown == std::isnan(answer.probability));
  const bool is_visible = (answer.flags & kAnswerNotVisible) == 0;
  const std::span<const double> ranges = reader.info().ranges_m;
  SIGHTLINE_CHECK(answer.look.return_count > 0 ||
                  std::find(ranges.begin(), ranges.end(), answer.look.range_m) != ranges.end());
  SIGHTLINE_CHECK(!is_visible || answer.look.range_m <= 60.0);
  SIGHTLINE_CHECK(is_visible || is_unknown || answer.probability == 0.0);
}

void look_up(std::span<const std::byte> file) {
  const Result<MapReader> reader = MapReader::open(file, "annealed");
  if (!reader) return;
  const std::array<double, 3>& origin = reader->info().origin_world_m;
  const double tile_m = reader->info().tile_m;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      const Result<RangeAnswer> answer = reader->observation_range(
          {origin[0] + (x + 0.5) * tile_m, origin[1] + (y + 0.5) * tile_m, origin[2]}, 0.2);
      if (answer) check_answer(*reader, *answer);
      const Result<LookAnswer> look = reader->look(
          {origin[0] + (x + 0.5) * tile_m, origin[1] + (y + 0.5) * tile_m, origin[2]}, 0.2, 60.0);
      if (look) check_look(*reader, *look);
    }
  }
}

void read_all(std::span<const std::byte> file) {
  const Result<CompiledMap> map = read_map(file);
  if (!map) return;
  SIGHTLINE_CHECK(validate(*map));
  const std::vector<std::byte> again = encode_map(*map);
  const Result<CompiledMap> back = read_map(again);
  SIGHTLINE_CHECK(back.has_value());
  SIGHTLINE_CHECK(encode_map(*back) == again);
}

// Where the parts of a map lie that are worth a mutation of their own.
std::span<std::byte> some_part(std::span<std::byte> file, unsigned int seed) {
  if (file.size() < kHeaderSize + kTrailerSize) return file;
  const Result<FileHeader> header = decode_header(file);
  if (!header || seed % 4 == 0) return file;
  const auto within = [&](std::uint64_t offset, std::uint64_t size) {
    const bool fits = offset <= file.size() && size <= file.size() - offset;
    return fits ? file.subspan(offset, size) : file;
  };
  if (seed % 4 == 1) return within(header->manifest_offset, header->manifest_size);
  if (seed % 4 == 2) return within(header->directory_offset, header->directory_size);
  // A few columns of a layer, somewhere between manifest and directory.
  const std::uint64_t first = header->manifest_offset + header->manifest_size;
  if (first >= header->directory_offset || header->directory_offset > file.size()) return file;
  const std::uint64_t size = header->directory_offset - first;
  const std::uint64_t skipped = seed / 4 % size;
  return within(first + skipped, std::min<std::uint64_t>(size - skipped, 256));
}

}  // namespace
}  // namespace sightline

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned int seed) {
  using namespace sightline;
  if (seed % 16 == 0) {
    size = LLVMFuzzerMutate(data, size, max_size);
  } else {
    mutate_in_place(some_part(std::as_writable_bytes(std::span(data, size)), seed / 16));
  }
  if (seed % 32 != 1) repair_map(std::as_writable_bytes(std::span(data, size)));
  return size;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const sightline::FuzzInput input(data, size);
  sightline::look_up(input.bytes());
  sightline::read_all(input.bytes());
  return 0;
}
