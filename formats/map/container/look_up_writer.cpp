#include "formats/map/container/look_up_writer.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "formats/reader/look_up.h"

namespace sightline {
namespace {

// Holds 16 sites of a street, which one look-up reads from one page or two.
constexpr double kCell_m = 16.0;

template <class T>
T load(std::span<const std::byte> bytes, std::uint64_t column, std::uint64_t i) {
  T value;
  std::memcpy(&value, bytes.data() + column + i * sizeof(T), sizeof value);
  return value;
}

template <class T>
void store(std::byte* bytes, T value) {
  std::memcpy(bytes, &value, sizeof value);
}

std::byte* page_of(std::vector<std::byte>& section, std::uint64_t number) {
  return section.data() + number * kPageSize;
}

std::string text_of(const BlockKinds& kinds) {
  std::string text;
  for (const auto& [name, version] : kinds) text += name + " " + std::to_string(version) + "\n";
  return text;
}

void insert_slot(std::vector<std::byte>& section, std::uint64_t slot_count,
                 const LookUpSlot& slot) {
  for (std::uint64_t place = first_slot(slot.x, slot.y, slot_count);;
       place = (place + 1) % slot_count) {
    std::byte* bytes =
        page_of(section, place / kSlotsPerPage) + place % kSlotsPerPage * sizeof(LookUpSlot);
    LookUpSlot taken;
    std::memcpy(&taken, bytes, sizeof taken);
    if (taken.row_count == 0) return store(bytes, slot);
  }
}

}  // namespace

LookUpBuilder::LookUpBuilder(const AnswerShape& shape, double reach_m)
    : shape_(shape), cell_m_(std::max(kCell_m, reach_m / 4.0)) {}

bool LookUpBuilder::add_choices(std::span<const std::byte> raw, const RangeLayout& from,
                                std::uint64_t row, std::byte* out) const {
  const LookUpRowLayout to(shape_);
  for (std::uint64_t limit = 0; limit < shape_.limits; ++limit) {
    const std::uint64_t choice = row * shape_.limits + limit;
    const auto range = load<std::uint8_t>(raw, from.range_index, choice);
    if (range >= shape_.ranges) return false;
    const std::uint64_t cell = row * shape_.ranges + range;
    to.put_share(out, to.probability, limit,
                 load<double>(raw, from.probability, cell * shape_.limits + limit));
    to.put_length(out, to.mean_error, limit, load<double>(raw, from.mean_error, cell));
    store(out + to.range_index + limit, range);
    store(out + to.range_flags + limit, load<std::uint8_t>(raw, from.range_flags, choice));
    store(out + to.range_reason + limit, load<std::uint8_t>(raw, from.range_reason, choice));
    if (shape_.looks == 0) continue;
    const auto look = load<std::uint8_t>(raw, from.look_index, choice);
    if (look >= shape_.looks) return false;
    const std::uint64_t look_cell = row * shape_.looks + look;
    to.put_share(out, to.look_probability, limit,
                 load<double>(raw, from.look_probability, look_cell * shape_.limits + limit));
    to.put_length(out, to.look_mean_error, limit,
                  load<double>(raw, from.look_mean_error, look_cell));
    store(out + to.look_index + limit, look);
    store(out + to.look_flags + limit, load<std::uint8_t>(raw, from.look_flags, choice));
    store(out + to.look_reason + limit, load<std::uint8_t>(raw, from.look_reason, choice));
  }
  return true;
}

bool LookUpBuilder::add(std::span<const std::byte> raw, std::uint64_t row_count) {
  const RangeLayout from(row_count, shape_);
  is_possible_ = is_possible_ && raw.size() == from.size;
  const LookUpRowLayout to(shape_);
  for (std::uint64_t row = 0; row < row_count && is_possible_; ++row) {
    const double p_x_m = load<double>(raw, from.p_x, row);
    const double p_y_m = load<double>(raw, from.p_y, row);
    constexpr double kFarthestCell = 0x1.0p30;
    is_possible_ = std::abs(p_x_m) < kFarthestCell * cell_m_ &&
                   std::abs(p_y_m) < kFarthestCell * cell_m_;  // and so neither is NaN
    if (!is_possible_) break;
    const auto site = load<std::uint32_t>(raw, from.site, row);
    places_.push_back({static_cast<std::int32_t>(std::floor(p_x_m / cell_m_)),
                       static_cast<std::int32_t>(std::floor(p_y_m / cell_m_)), site, rows_.size()});
    rows_.resize(rows_.size() + to.size);
    std::byte* out = rows_.data() + places_.back().offset;
    to.put_place(out, 0, p_x_m);
    to.put_place(out, 1, p_y_m);
    to.put_place(out, 2, load<double>(raw, from.p_z, row));
    to.put_length(out, to.longest_error, 0,
                  load<double>(raw, from.mean_error, row * shape_.ranges + shape_.ranges - 1));
    store(out + to.site, site);
    is_possible_ = add_choices(raw, from, row, out);
  }
  return is_possible_;
}

std::vector<std::byte> LookUpBuilder::finish(const FileHeader& header,
                                             const BlockKinds& required) const {
  const std::string required_blocks = text_of(required);
  if (!is_possible_ || places_.empty() || required_blocks.size() > kMostRequiredText) return {};
  std::vector<Place> sorted = places_;
  std::ranges::sort(sorted);
  std::uint64_t cells = 1;
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    if (sorted[i].x != sorted[i - 1].x || sorted[i].y != sorted[i - 1].y) ++cells;
  }
  LookUpInfo info;
  info.cell_m = cell_m_;
  info.slot_count = 2 * cells;  // half empty, so that a search is short
  info.row_count = sorted.size();
  info.limit_count = static_cast<std::uint32_t>(shape_.limits);
  info.look_count = static_cast<std::uint32_t>(shape_.looks);
  info.is_small = shape_.is_small;
  info.required_blocks = required_blocks;
  const std::uint64_t first_row_page = slot_page_count(info);
  info.page_count = first_row_page + row_page_count(info) + 1;

  const LookUpRowLayout layout(shape_);
  std::vector<std::byte> section(info.page_count * kPageSize);
  for (std::size_t first = 0; first < sorted.size();) {
    std::size_t end = first;
    while (end < sorted.size() && sorted[end].x == sorted[first].x &&
           sorted[end].y == sorted[first].y) {
      std::memcpy(page_of(section, first_row_page + end / layout.rows_per_page) +
                      end % layout.rows_per_page * layout.size,
                  rows_.data() + sorted[end].offset, layout.size);
      ++end;
    }
    insert_slot(section, info.slot_count,
                {sorted[first].x, sorted[first].y, static_cast<std::uint32_t>(first),
                 static_cast<std::uint32_t>(end - first)});
    first = end;
  }
  encode_look_up_info(info, std::span(page_of(section, info.page_count - 1), kPageSize));
  for (std::uint64_t number = 0; number < info.page_count; ++number) {
    seal_page(std::span(page_of(section, number), kPageSize), number, page_seed(header));
  }
  return section;
}

}  // namespace sightline
