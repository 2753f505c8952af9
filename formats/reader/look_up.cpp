#include "formats/reader/look_up.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string_view>
#include <type_traits>

#include "formats/base/bytes.h"
#include "formats/base/level.h"
#include "formats/reader/map_checks.h"
#include "formats/record/codec.h"
#include "map_generated.h"

namespace sightline {

// Behind the magic, the version and the size of a page.
SIGHTLINE_SOME_FIELDS(LookUpInfo, page_count, cell_m, slot_count, row_count, limit_count)

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

template <class T>
void store(std::byte* bytes, T value) {
  std::memcpy(bytes, &value, sizeof value);
}

// The nearest that T can be.
template <class T>
T whole_multiple(double value, double unit) {
  using Limits = std::numeric_limits<T>;
  const double count = std::round(value / unit);
  if (!(count > static_cast<double>(Limits::min()))) return Limits::min();
  return static_cast<T>(std::min(count, static_cast<double>(Limits::max())));
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
  decode(reader, info);
  const auto text_size = std::min<std::size_t>(reader.get<std::uint32_t>(), kMostRequiredText);
  reader.get(info.look_count);
  info.is_small = reader.get<std::uint32_t>() != 0;
  info.required_blocks.assign(reinterpret_cast<const char*>(page) + 64, text_size);
  return info;
}

LookUpRowLayout layout_of(const LookUpInfo& info) {
  return LookUpRowLayout({0, info.limit_count, info.look_count, info.is_small});
}

// Numbers that no sum of them can overflow, then that they agree.
Result<void> check_info(const LookUpInfo& info, const MapFront& front, std::uint64_t byte) {
  const double reach_m = front.manifest->reach_m();
  if (!std::isfinite(info.cell_m) || !(info.cell_m * kMostCellsOfReach >= reach_m)) {
    return bad_section(ErrorCode::kBadLayer,
                       "the size of the cells is not above 0 m, or too small for the reach", byte);
  }
  if (info.slot_count == 0 || info.slot_count > UINT32_MAX || info.row_count > UINT32_MAX ||
      info.row_count != front.manifest->site_count() ||
      info.limit_count != front.manifest->promises()->size() ||
      info.look_count != answer_shape(*front.manifest).looks ||
      info.is_small != answer_shape(*front.manifest).is_small ||
      info.page_count != slot_page_count(info) + row_page_count(info) + 1 ||
      info.page_count > front.header.directory_offset / kPageSize) {
    return bad_section(ErrorCode::kBadLayer, "counts differ from each other or from the manifest",
                       byte);
  }
  return {};
}

// The line "name version" names what this program knows.
bool is_known(std::string_view line) { return line == "ndt 1" || line == "range 2"; }

Result<void> check_required(std::string_view text, std::uint64_t byte) {
  static_assert(kNdtLayerVersion == 1 && kRangeLayerVersion == 2);
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    if (!is_known(line)) {
      return bad_section(
          ErrorCode::kUnknownRequiredFeature,
          concat("block ", line, " (name and version) is required and unknown to this program"),
          byte);
    }
    text.remove_prefix(std::min(text.size(), line.size() + 1));
  }
  return {};
}

// The cells of one axis by their distance from a coordinate: its own, the next on the nearer side,
// the next on the other side, and so on.
class CellsByDistance {
 public:
  CellsByDistance(double value_m, double cell_m)
      : cell_(static_cast<std::int32_t>(std::floor(value_m / cell_m))), cell_m_(cell_m) {
    below_m_ = value_m - cell_ * cell_m;
    above_m_ = cell_m - below_m_;
  }
  // Of the step-th of them.
  [[nodiscard]] std::int32_t cell(std::int32_t step) const {
    const std::int32_t away = (step + 1) / 2;
    return is_below(step) ? cell_ - away : cell_ + away;
  }
  // How far away its sites are at least; a millionth of a cell less than it seems, since the
  // rounding of a quotient may put a site into the cell beside its own.
  [[nodiscard]] double gap_m(std::int32_t step) const {
    if (step == 0) return 0.0;
    const double border_m = is_below(step) ? below_m_ : above_m_;
    return std::max(0.0, border_m + ((step + 1) / 2 - 1 - 1e-6) * cell_m_);
  }

 private:
  [[nodiscard]] bool is_below(std::int32_t step) const {
    return (step % 2 == 1) == (below_m_ < above_m_);
  }
  std::int32_t cell_;
  double cell_m_;
  double below_m_;  // to the borders of the own cell
  double above_m_;
};

struct RowAndDistance {
  const std::byte* row = nullptr;
  double distance2_m2 = std::numeric_limits<double>::infinity();
};

// The first of the nearest of `count` rows on the level of `p_m`. Without a branch that hangs on a
// distance: a processor that guesses it wrong waits for one row after the other, and most of a
// look-up's time is such waiting.
template <class Place>
RowAndDistance nearest_row(const std::byte* rows, std::uint64_t count, std::uint64_t row_size,
                           const std::array<double, 3>& p_m) {
  constexpr double kUnit_m = std::is_integral_v<Place> ? kSmallLength_m : 1.0;
  const auto place_m = [&](std::size_t axis) {
    return kUnit_m * static_cast<double>(load<Place>(rows + axis * sizeof(Place)));
  };
  RowAndDistance nearest;
  for (std::uint64_t i = 0; i < count; ++i, rows += row_size) {
    const double dx_m = place_m(0) - p_m[0];
    const double dy_m = place_m(1) - p_m[1];
    const double dz_m = place_m(2) - p_m[2];
    const double distance2_m2 = dx_m * dx_m + dy_m * dy_m + dz_m * dz_m;
    const bool is_on_level = is_same_level(dz_m, 0.0);
    const bool is_nearer = is_on_level & (distance2_m2 < nearest.distance2_m2);
    nearest.distance2_m2 = is_nearer ? distance2_m2 : nearest.distance2_m2;
    nearest.row = is_nearer ? rows : nearest.row;
  }
  return nearest;
}

// Keeps the lower site of two that are equally near.
void take_nearer(const RowAndDistance& found, const LookUpRowLayout& layout,
                 LookUp::Nearest& nearest) {
  if (found.row == nullptr || found.distance2_m2 > nearest.distance2_m2) return;
  const auto site = load<std::uint32_t>(found.row + layout.site);
  const bool is_tie = nearest.row != nullptr && found.distance2_m2 == nearest.distance2_m2;
  if (is_tie && site >= nearest.site) return;
  nearest.distance2_m2 = found.distance2_m2;
  nearest.row = found.row;
  nearest.site = site;
}

}  // namespace

std::uint64_t slot_page_count(const LookUpInfo& info) {
  return divide_up(info.slot_count, kSlotsPerPage);
}

std::uint64_t row_page_count(const LookUpInfo& info) {
  return divide_up(info.row_count, layout_of(info).rows_per_page);
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
  encode(info, writer);
  writer.put(static_cast<std::uint32_t>(info.required_blocks.size()));
  writer.put(info.look_count);
  writer.put<std::uint32_t>(info.is_small ? 1 : 0);
  writer.append(info.required_blocks.data(), info.required_blocks.size());
  std::copy(writer.bytes().begin(), writer.bytes().end(), page.begin());
}

double LookUpRowLayout::place_m(const std::byte* row, std::size_t axis) const {
  if (!is_small) return load<double>(row + 8 * axis);
  return kSmallLength_m * load<std::int32_t>(row + 4 * axis);
}

double LookUpRowLayout::length_m(const std::byte* row, std::uint64_t field, std::size_t i) const {
  const std::byte* value = row + field + value_size * i;
  return is_small ? kSmallLength_m * load<std::uint16_t>(value) : load<double>(value);
}

double LookUpRowLayout::share(const std::byte* row, std::uint64_t field, std::size_t i) const {
  const std::byte* value = row + field + value_size * i;
  return is_small ? kSmallShare * load<std::uint16_t>(value) : load<double>(value);
}

void LookUpRowLayout::put_place(std::byte* row, std::size_t axis, double value_m) const {
  if (!is_small) return store(row + 8 * axis, value_m);
  store(row + 4 * axis, whole_multiple<std::int32_t>(value_m, kSmallLength_m));
}

void LookUpRowLayout::put_length(std::byte* row, std::uint64_t field, std::size_t i,
                                 double value_m) const {
  std::byte* value = row + field + value_size * i;
  if (!is_small) return store(value, value_m);
  store(value, whole_multiple<std::uint16_t>(value_m, kSmallLength_m));
}

void LookUpRowLayout::put_share(std::byte* row, std::uint64_t field, std::size_t i,
                                double value_of_share) const {
  std::byte* value = row + field + value_size * i;
  if (!is_small) return store(value, value_of_share);
  store(value, whole_multiple<std::uint16_t>(value_of_share, kSmallShare));
}

LookUp::LookUp(const MapFront& front, const LookUpInfo& info, std::uint64_t offset)
    : pages_(front.file.data() + offset),
      offset_(offset),
      seed_(page_seed(front.header)),
      reach_m_(front.manifest->reach_m()),
      cell_m_(info.cell_m),
      slot_count_(info.slot_count),
      // Each cell has a row of its own, so one slot more is the cell that is sought or empty.
      most_slots_(std::min(info.slot_count, info.row_count + 1)),
      first_row_page_(slot_page_count(info)),
      row_count_(info.row_count),
      row_layout_(layout_of(info)),
      is_checked_(std::make_unique<std::atomic<std::uint8_t>[]>(info.page_count)) {}

Result<LookUp> LookUp::open(const MapFront& front) {
  if (!has_look_up(front.header)) {
    return Error{ErrorCode::kBadLayer,
                 "the header does not list the section look-up, which every map needs", "",
                 "byte 16"};
  }
  const std::uint64_t end = front.header.directory_offset;
  if (end > front.file.size() || end < kHeaderSize + kPageSize || end % kAlignment != 0) {
    return bad_section(ErrorCode::kOutOfBounds, "the file is too short for it", end);
  }
  const std::uint64_t last = end - kPageSize;
  const std::byte* page = front.file.data() + last;
  if (std::memcmp(page, kPageMagic.data(), kPageMagic.size()) != 0 ||
      load<std::uint32_t>(page + 12) != kPageSize) {
    return bad_section(ErrorCode::kBadLayer, "its last page is missing", last);
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
  SIGHTLINE_TRY(check_required(info.required_blocks, last));
  SIGHTLINE_TRY(check_info(info, front, last));
  return LookUp(front, info, end - info.page_count * kPageSize);
}

Error LookUp::damage(const Nearest& nearest) const {
  if (nearest.bad_page == kNone) {
    return bad_section(ErrorCode::kBadLayer,
                       "a cell refers to rows that are missing, or there are more cells than rows",
                       offset_);
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

LookUp::Nearest LookUp::row(std::uint64_t number) const {
  SIGHTLINE_CHECK(number < row_count_);
  Nearest found;
  const std::byte* rows = page(first_row_page_ + number / row_layout_.rows_per_page, found);
  if (rows == nullptr) return found;
  found.row = rows + number % row_layout_.rows_per_page * row_layout_.size;
  found.site = load<std::uint32_t>(found.row + row_layout_.site);
  return found;
}

void LookUp::prefetch_cell(std::int32_t x, std::int32_t y) const {
  const std::uint64_t place = first_slot(x, y, slot_count_);
  __builtin_prefetch(pages_ + place / kSlotsPerPage * kPageSize +
                     place % kSlotsPerPage * sizeof(LookUpSlot));
}

// An empty slot where there is no such cell.
LookUpSlot LookUp::find_cell(std::int32_t x, std::int32_t y, Nearest& nearest) const {
  std::uint64_t place = first_slot(x, y, slot_count_);
  for (std::uint64_t tried = 0; tried < most_slots_; ++tried) {
    const std::byte* slots = page(place / kSlotsPerPage, nearest);
    if (slots == nullptr) return {};
    const auto slot = load<LookUpSlot>(slots + place % kSlotsPerPage * sizeof(LookUpSlot));
    if (slot.row_count == 0 || (slot.x == x && slot.y == y)) return slot;
    if (++place == slot_count_) place = 0;
  }
  nearest.is_damaged = true;
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
    const auto nearest_of =
        row_layout_.is_small ? &nearest_row<std::int32_t> : &nearest_row<double>;
    take_nearer(nearest_of(rows, page_end - row, row_layout_.size, p_m), row_layout_, nearest);
    row = page_end;
  }
}

LookUp::Nearest LookUp::nearest(const std::array<double, 3>& p_m) const {
  Nearest nearest;
  nearest.distance2_m2 = reach_m_ * reach_m_;
  // Keys are 32 bits wide: beyond this no cell can be.
  const double farthest_m = 0x1.0p30 * cell_m_;
  if (std::max(std::abs(p_m[0]), std::abs(p_m[1])) > farthest_m) return nearest;
  const CellsByDistance xs(p_m[0], cell_m_);
  const CellsByDistance ys(p_m[1], cell_m_);
  // Near a border these are asked next; their memory comes while that of the own cell is waited
  // for.
  prefetch_cell(xs.cell(0), ys.cell(1));
  prefetch_cell(xs.cell(1), ys.cell(0));
  // The own cell comes first, and what it finds spares most of the others. Gaps are also compared
  // unsquared, because no damaged reach may make this endless.
  for (std::int32_t i = 0; xs.gap_m(i) <= reach_m_; ++i) {
    const double gap2_m2 = xs.gap_m(i) * xs.gap_m(i);
    if (gap2_m2 > nearest.distance2_m2) break;
    for (std::int32_t j = 0; ys.gap_m(j) <= reach_m_; ++j) {
      if (gap2_m2 + ys.gap_m(j) * ys.gap_m(j) > nearest.distance2_m2) break;
      search_cell(xs.cell(i), ys.cell(j), p_m, nearest);
      if (nearest.is_damaged) return nearest;
    }
  }
  return nearest;
}

}  // namespace sightline
