#include "formats/reader/look_up.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>

#include "compiler/base/bytes.h"
#include "formats/reader/map_checks.h"
#include "map_generated.h"

namespace sightline {
namespace {

using PageMagic = std::array<std::uint8_t, 8>;
constexpr PageMagic kPageMagic = {0x89, 'S', 'L', 'U', '\r', '\n', 0x1A, '\n'};
constexpr std::uint8_t kGood = 1;  // a page that was checked

// So that a place far from any site is known to be far after at most 17 x 17 cells.
constexpr double kMostCellsOfReach = 8.0;

template <class T>
T load(const std::byte* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

std::uint64_t divide_up(std::uint64_t count, std::uint64_t per_page) {
  return count / per_page + (count % per_page == 0 ? 0 : 1);
}

std::uint64_t page_checksum(std::span<const std::byte> page, std::uint64_t seed) {
  return XXH3_64bits_withSeed(page.data(), kPageSize - 8, seed);
}

bool is_sealed(const std::byte* page, std::uint64_t number, std::uint64_t seed) {
  return load<std::uint64_t>(page + kPagePayload) == number &&
         load<std::uint64_t>(page + kPageSize - 8) == page_checksum({page, kPageSize}, seed);
}

Error bad_section(ErrorCode code, std::string message, std::uint64_t byte) {
  return {code, std::move(message), "", "section look-up, byte " + std::to_string(byte)};
}

LookUpInfo decode_info(const std::byte* page) {
  ByteReader reader(std::span(page, kPagePayload).subspan(16));
  LookUpInfo info;
  reader.get(info.page_count);
  reader.get(info.cell_m);
  reader.get(info.slot_count);
  reader.get(info.row_count);
  reader.get(info.limit_count);
  const auto text_size = std::min<std::size_t>(reader.get<std::uint32_t>(), kMostRequiredText);
  info.required_blocks.assign(reinterpret_cast<const char*>(page) + 64, text_size);
  return info;
}

// Numbers that no sum of them can overflow, then that they agree.
Result<void> check_info(const LookUpInfo& info, const MapFront& front, std::uint64_t byte) {
  const double reach_m = front.manifest->reach_m();
  if (!std::isfinite(info.cell_m) || !(info.cell_m * kMostCellsOfReach >= reach_m)) {
    return bad_section(ErrorCode::kBadLayer, "cells are no length, or too small for the reach",
                       byte);
  }
  if (info.slot_count == 0 || info.slot_count > UINT32_MAX || info.row_count > UINT32_MAX ||
      info.row_count != front.manifest->site_count() ||
      info.limit_count != front.manifest->promises()->size() ||
      info.page_count != slot_page_count(info) + row_page_count(info) + 1 ||
      info.page_count > front.header.directory_offset / kPageSize) {
    return bad_section(ErrorCode::kBadLayer, "counts disagree with each other or the manifest",
                       byte);
  }
  return {};
}

// The line "name version" names what this program knows.
bool is_known(std::string_view line) {
  return line == "ndt 1" || line == "range 1";
}

Result<void> check_required(std::string_view text, std::uint64_t byte) {
  static_assert(kNdtLayerVersion == 1 && kRangeLayerVersion == 1);
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    if (!is_known(line)) {
      return bad_section(ErrorCode::kUnknownRequiredFeature,
                         "block " + std::string(line) + " (name and version)" +
                             " is required and unknown to this program",
                         byte);
    }
    text.remove_prefix(std::min(text.size(), line.size() + 1));
  }
  return {};
}

std::int32_t cell_of(double coordinate_m, double cell_m) {
  return static_cast<std::int32_t>(std::floor(coordinate_m / cell_m));
}

// Distance from a coordinate to the interval of one cell along an axis.
double gap_m(double value_m, std::int32_t cell, double cell_m) {
  const double low_m = cell * cell_m;
  return std::max({0.0, low_m - value_m, value_m - (low_m + cell_m)});
}

}  // namespace

std::uint64_t slot_page_count(const LookUpInfo& info) {
  return divide_up(info.slot_count, kSlotsPerPage);
}

std::uint64_t row_page_count(const LookUpInfo& info) {
  return divide_up(info.row_count, LookUpRowLayout(info.limit_count).rows_per_page);
}

std::uint64_t page_seed(const FileHeader& header) {
  std::uint64_t seed = 0;
  std::memcpy(&seed, header.root_digest.data(), sizeof seed);
  return seed;
}

void seal_page(std::span<std::byte> page, std::uint64_t number, std::uint64_t seed) {
  SIGHTLINE_CHECK(page.size() == kPageSize);
  std::memcpy(page.data() + kPagePayload, &number, sizeof number);
  const std::uint64_t checksum = page_checksum(page, seed);
  std::memcpy(page.data() + kPageSize - 8, &checksum, sizeof checksum);
}

void encode_look_up_info(const LookUpInfo& info, std::span<std::byte> page) {
  SIGHTLINE_CHECK(info.required_blocks.size() <= kMostRequiredText);
  ByteWriter writer;
  writer.append(kPageMagic.data(), kPageMagic.size());
  writer.put(kLookUpSectionVersion);
  writer.put(static_cast<std::uint32_t>(kPageSize));
  writer.put(info.page_count);
  writer.put(info.cell_m);
  writer.put(info.slot_count);
  writer.put(info.row_count);
  writer.put(info.limit_count);
  writer.put(static_cast<std::uint32_t>(info.required_blocks.size()));
  writer.put<std::uint64_t>(0);
  writer.append(info.required_blocks.data(), info.required_blocks.size());
  std::copy(writer.bytes().begin(), writer.bytes().end(), page.begin());
}

LookUp::LookUp(const MapFront& front, const LookUpInfo& info, std::uint64_t offset)
    : pages_(front.file.data() + offset),
      offset_(offset),
      seed_(page_seed(front.header)),
      reach_m_(front.manifest->reach_m()),
      cell_m_(info.cell_m),
      slot_count_(info.slot_count),
      first_row_page_(slot_page_count(info)),
      row_count_(info.row_count),
      row_layout_(info.limit_count),
      is_checked_(std::make_unique<std::atomic<std::uint8_t>[]>(info.page_count)) {}

Result<LookUp> LookUp::open(const MapFront& front) {
  const std::uint64_t end = front.header.directory_offset;
  if (end > front.file.size() || end < kHeaderSize + kPageSize || end % kAlignment != 0) {
    return bad_section(ErrorCode::kOutOfBounds, "there is no room for it", end);
  }
  const std::uint64_t last = end - kPageSize;
  const std::byte* page = front.file.data() + last;
  if (std::memcmp(page, kPageMagic.data(), kPageMagic.size()) != 0 ||
      load<std::uint32_t>(page + 12) != kPageSize) {
    return bad_section(ErrorCode::kBadLayer, "its last page is none", last);
  }
  const LookUpInfo info = decode_info(page);
  if (!is_sealed(page, info.page_count - 1, page_seed(front.header))) {
    return bad_section(ErrorCode::kChecksumMismatch, "its last page does not match its checksum",
                       last);
  }
  if (load<std::uint32_t>(page + 8) != kLookUpSectionVersion) {
    return bad_section(ErrorCode::kUnknownRequiredFeature, "of a version unknown to this program",
                       last);
  }
  const Result<void> required = check_required(info.required_blocks, last);
  if (!required) return required.error();
  const Result<void> sane = check_info(info, front, last);
  if (!sane) return sane.error();
  return LookUp(front, info, end - info.page_count * kPageSize);
}

Error LookUp::damage(const Nearest& nearest) const {
  if (nearest.bad_page == kNone) {
    return bad_section(ErrorCode::kBadLayer, "a cell names rows that are not there", offset_);
  }
  return bad_section(ErrorCode::kChecksumMismatch, "a page does not match its checksum",
                     offset_ + nearest.bad_page * kPageSize);
}

const std::byte* LookUp::page(std::uint64_t number, Nearest& nearest) const {
  const std::byte* bytes = pages_ + number * kPageSize;
  if (is_checked_[number].load(std::memory_order_acquire) == kGood) return bytes;
  if (!is_sealed(bytes, number, seed_)) {
    nearest.is_damaged = true;
    nearest.bad_page = number;
    return nullptr;
  }
  is_checked_[number].store(kGood, std::memory_order_release);
  return bytes;
}

// An empty slot where there is no such cell.
LookUpSlot LookUp::find_cell(std::int32_t x, std::int32_t y, Nearest& nearest) const {
  std::uint64_t place = first_slot(x, y, slot_count_);
  for (std::uint64_t tried = 0; tried < slot_count_; ++tried) {
    const std::byte* slots = page(place / kSlotsPerPage, nearest);
    if (slots == nullptr) return {};
    const auto slot = load<LookUpSlot>(slots + place % kSlotsPerPage * sizeof(LookUpSlot));
    if (slot.row_count == 0 || (slot.x == x && slot.y == y)) return slot;
    if (++place == slot_count_) place = 0;
  }
  return {};
}

void LookUp::search_cell(std::int32_t x, std::int32_t y, const std::array<double, 3>& p_m,
                         Nearest& nearest) const {
  const LookUpSlot slot = find_cell(x, y, nearest);
  const std::uint64_t end = std::uint64_t{slot.first_row} + slot.row_count;
  if (end > row_count_) {
    nearest.is_damaged = true;
    return;
  }
  std::uint64_t row = slot.first_row;
  while (row < end) {
    const std::uint64_t number = row / row_layout_.rows_per_page;
    const std::byte* rows = page(first_row_page_ + number, nearest);
    if (rows == nullptr) return;
    const std::uint64_t page_end = std::min(end, (number + 1) * row_layout_.rows_per_page);
    rows += (row - number * row_layout_.rows_per_page) * row_layout_.size;
    for (; row < page_end; ++row, rows += row_layout_.size) {
      const double dx_m = load<double>(rows) - p_m[0];
      const double dy_m = load<double>(rows + 8) - p_m[1];
      const double dz_m = load<double>(rows + 16) - p_m[2];
      const double distance2_m2 = dx_m * dx_m + dy_m * dy_m + dz_m * dz_m;
      if (!(distance2_m2 <= nearest.distance2_m2)) continue;
      const auto site = load<std::uint32_t>(rows + LookUpRowLayout::site);
      if (distance2_m2 == nearest.distance2_m2 && nearest.row != nullptr && site >= nearest.site) {
        continue;
      }
      nearest.distance2_m2 = distance2_m2;
      nearest.row = rows;
      nearest.site = site;
    }
  }
}

LookUp::Nearest LookUp::nearest(const std::array<double, 3>& p_m) const {
  Nearest nearest;
  nearest.distance2_m2 = reach_m_ * reach_m_;
  // Beyond this no cell can be: keys are 32 bits wide.
  constexpr double kFarthestCell = 0x1.0p30;
  const double reach_m = kFarthestCell * cell_m_;
  if (std::max(std::abs(p_m[0]), std::abs(p_m[1])) > reach_m) return nearest;
  const std::int32_t x = cell_of(p_m[0], cell_m_);
  const std::int32_t y = cell_of(p_m[1], cell_m_);
  // The own cell first: what it finds spares most of the others.
  search_cell(x, y, p_m, nearest);
  // A micrometre more, for the rounding of sums; gaps are compared exactly.
  const double within_m = std::sqrt(nearest.distance2_m2) + 1e-6;
  const std::int32_t x_end = cell_of(p_m[0] + within_m, cell_m_);
  const std::int32_t y_end = cell_of(p_m[1] + within_m, cell_m_);
  for (std::int32_t i = cell_of(p_m[0] - within_m, cell_m_); i <= x_end; ++i) {
    for (std::int32_t j = cell_of(p_m[1] - within_m, cell_m_); j <= y_end; ++j) {
      if ((i == x && j == y) || nearest.is_damaged) continue;
      const double gap_x_m = gap_m(p_m[0], i, cell_m_);
      const double gap_y_m = gap_m(p_m[1], j, cell_m_);
      if (gap_x_m * gap_x_m + gap_y_m * gap_y_m > nearest.distance2_m2) continue;
      search_cell(i, j, p_m, nearest);
    }
  }
  return nearest;
}

}  // namespace sightline
