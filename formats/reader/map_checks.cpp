#include "formats/reader/map_checks.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "map_generated.h"

namespace sightline {
namespace {

using Numbers = flatbuffers::Vector<double>;
using Blocks = flatbuffers::Vector<flatbuffers::Offset<schema::Block>>;

Error bad_manifest(const std::string& message) {
  return {ErrorCode::kBadManifest, message, "", "manifest"};
}

Error unknown_feature(const std::string& what, const std::string& place) {
  return {ErrorCode::kUnknownRequiredFeature, what + " unknown to this program", "", place};
}

bool is_finite(double value) { return std::isfinite(value); }

bool is_positive(double value) { return std::isfinite(value) && value > 0.0; }

bool is_ascending_and_positive(const Numbers& values) {
  double previous = 0.0;
  for (const double value : values) {
    if (!std::isfinite(value) || value <= previous) return false;
    previous = value;
  }
  return true;
}

// The verifier of FlatBuffers looks at the alignment of a vector's length, not of its elements.
template <class T>
bool is_aligned(const flatbuffers::Vector<T>& vector) {
  return vector.size() == 0 ||
         reinterpret_cast<std::uintptr_t>(vector.Data()) % sizeof(double) == 0;
}

using Promises = flatbuffers::Vector<flatbuffers::Offset<schema::Promise>>;
using Qualities = flatbuffers::Vector<flatbuffers::Offset<schema::LimitQuality>>;

Result<void> check_promises(const Promises& promises, const Qualities& quality) {
  if (promises.size() == 0 || promises.size() > kMostLimits || promises.size() != quality.size()) {
    return bad_manifest(concat("found ", promises.size(), " limits, expected 1 to ", kMostLimits,
                               ", each with its quality"));
  }
  double previous_m = 0.0;
  for (const schema::Promise* promise : promises) {
    if (!std::isfinite(promise->limit_m()) || promise->limit_m() <= previous_m) {
      return Error{ErrorCode::kBadOrder, "limits are not positive and ascending", "", "manifest"};
    }
    if (promise->scope() > schema::Scope::MAX) {
      return bad_manifest("a promise has an unknown scope");
    }
    previous_m = promise->limit_m();
  }
  return {};
}

bool is_sample(const schema::Look& look) {
  const bool is_even_length = look.even_beyond_m() == 0.0 || is_positive(look.even_beyond_m());
  return is_positive(look.range_m()) && look.return_count() > 0 && is_even_length &&
         (!look.is_by_normals() || look.point_count() > 0) && look.mode() <= schema::LookMode::MAX;
}

// None, or one whose numbers make sense.
Result<void> check_look_plan(const schema::LookPlan* plan) {
  if (plan == nullptr) return {};
  const bool is_test = plan->weights()->size() == kPlanWeights && is_aligned(*plan->weights()) &&
                       std::ranges::all_of(*plan->weights(), is_finite) &&
                       std::isfinite(plan->constant()) && !std::isnan(plan->doubt_above());
  if (is_test && is_positive(plan->limit_m()) && is_sample(*plan->first()) &&
      is_sample(*plan->second())) {
    return {};
  }
  return bad_manifest("the plan of looks has a number out of range");
}

// None, or some with a promise for each limit of the map.
Result<void> check_looks(const schema::Manifest& manifest) {
  if (manifest.looks() == nullptr || manifest.looks()->size() == 0) {
    const bool has_more = manifest.look_promises() != nullptr ||
                          manifest.look_quality() != nullptr || manifest.look_plan() != nullptr;
    if (!has_more) return {};
    return bad_manifest("found promises of looks, but no look");
  }
  if (manifest.looks()->size() > kMostRanges) {
    return bad_manifest("found " + std::to_string(manifest.looks()->size()) + " looks");
  }
  for (const schema::Look* look : *manifest.looks()) {
    if (!is_sample(*look))
      return bad_manifest("a look takes no sample, or has a number out of range");
  }
  if (manifest.look_promises() == nullptr || manifest.look_quality() == nullptr ||
      manifest.look_promises()->size() != manifest.promises()->size()) {
    return bad_manifest("found looks without a promise for each limit");
  }
  SIGHTLINE_TRY(check_promises(*manifest.look_promises(), *manifest.look_quality()));
  for (flatbuffers::uoffset_t i = 0; i < manifest.promises()->size(); ++i) {
    if (manifest.look_promises()->Get(i)->limit_m() != manifest.promises()->Get(i)->limit_m()) {
      return bad_manifest("looks and ranges are chosen for different limits");
    }
  }
  return check_look_plan(manifest.look_plan());
}

// Values that a byte numbers, ascending.
Result<void> check_steps(const flatbuffers::Vector<float>& steps) {
  constexpr std::uint32_t kMost = 256;
  bool ascends = steps.size() > 0 && steps.size() <= kMost && !std::isnan(steps[0]);
  for (flatbuffers::uoffset_t i = 1; ascends && i < steps.size(); ++i) {
    ascends = steps[i - 1] < steps[i];
  }
  return ascends ? Result<void>()
                 : bad_manifest("a column of sites needs 1 to 256 steps, which ascend");
}

// None, or some with names that ascend.
Result<void> check_columns(const schema::Manifest& manifest) {
  if (manifest.columns() == nullptr) return {};
  if (manifest.columns()->size() > kMostColumns) {
    return bad_manifest(concat("found ", manifest.columns()->size(), " columns of sites"));
  }
  std::string_view previous;
  for (const schema::SiteColumn* column : *manifest.columns()) {
    const std::string_view name = column->name()->string_view();
    if (name <= previous) {
      return Error{ErrorCode::kBadOrder, "names of columns do not ascend", "", "manifest"};
    }
    previous = name;
    if (column->steps() != nullptr) SIGHTLINE_TRY(check_steps(*column->steps()));
  }
  return {};
}

Result<void> check_known(const schema::Block& block, const std::string& place) {
  const std::string_view name = block.name()->string_view();
  const bool is_ndt = name == kNdtLayer;
  const bool is_range = name == kRangeLayer;
  if (!block.is_required()) {
    if (!is_ndt && !is_range) return {};
    return Error{ErrorCode::kBadLayer, concat("layer ", name, " is marked optional"), "", place};
  }
  const std::uint32_t known = is_ndt ? kNdtLayerVersion : is_range ? kRangeLayerVersion : 0;
  if (known == 0 || block.version() != known) {
    return unknown_feature(
        concat("block ", name, " of version ", block.version(), " is required and"), place);
  }
  // Of sites, what changes little from row to row packs well; nothing else is done with them.
  const schema::Codec own = is_ndt ? schema::Codec::Nds : schema::Codec::Columns;
  const bool is_zstd = block.codec() == schema::Codec::Zstd;
  if (block.codec() != schema::Codec::None && block.codec() != own && !is_zstd) {
    return unknown_feature(
        concat("codec ", static_cast<int>(block.codec()), " of block ", name, " is"), place);
  }
  if (is_range && is_zstd) {
    return Error{ErrorCode::kBadLayer, "the range layer is compressed as a whole", "", place};
  }
  return {};
}

Result<void> check_rows(const schema::Manifest& manifest, const schema::Block& block,
                        const std::string& place) {
  if (!block.is_required()) return {};
  if (block.row_count() == 0 || block.row_count() > kMostRows) {
    return Error{ErrorCode::kTooLarge, concat("found ", block.row_count(), " rows"), "", place};
  }
  const std::uint64_t expected = block.name()->string_view() == kNdtLayer
                                     ? NdtLayout(block.row_count()).size
                                     : RangeLayout(block.row_count(), answer_shape(manifest)).size;
  if (block.raw_size() != expected) {
    return Error{ErrorCode::kBadLayer,
                 concat("found ", block.raw_size(), " bytes for ", block.row_count(),
                        " rows, expected ", expected),
                 "", place};
  }
  return {};
}

// Before anything is unpacked: what is claimed stays in proportion to the file.
Result<void> check_size(const schema::Block& block, const std::string& place) {
  if (block.codec() == schema::Codec::None && block.raw_size() != block.stored_size()) {
    return Error{ErrorCode::kBadLayer, "raw and stored sizes differ without a codec", "", place};
  }
  const bool is_known_codec = block.codec() <= schema::Codec::MAX;
  if ((block.is_required() && block.raw_size() > kLargestBlock) ||
      (is_known_codec && block.raw_size() / kMostExpansion > block.stored_size())) {
    return Error{ErrorCode::kTooLarge,
                 concat(block.stored_size(), " stored bytes cannot unpack to ", block.raw_size()),
                 "", place};
  }
  return {};
}

// Names ascend. The section "look-up" comes after all others, whatever their names: it ends where
// the directory begins.
bool is_in_order(std::string_view before, std::string_view after) {
  return std::pair(before == kLookUpSection, before) < std::pair(after == kLookUpSection, after);
}

// Walks through all blocks in their order; `end` is the first byte after the last one.
Result<void> check_blocks(const MapContainer& container, const Blocks& blocks,
                          const std::string& owner, std::uint64_t& end) {
  std::string_view previous;
  for (const schema::Block* block : blocks) {
    const std::string_view name = block->name()->string_view();
    const std::string place = owner + std::string(name);
    if (!is_in_order(previous, name))
      return Error{ErrorCode::kBadOrder, "names must ascend", "", place};
    previous = name;
    const std::uint64_t limit = container.header.directory_offset;
    if (block->offset() % kAlignment != 0 || block->offset() < end ||
        block->offset() - end >= kWidestGap || block->offset() > limit ||
        block->stored_size() > limit - block->offset()) {
      return Error{ErrorCode::kOutOfBounds,
                   concat("bytes ", block->offset(), " + ", block->stored_size(),
                          " are misaligned, overlap, leave a gap or leave the file"),
                   "", place};
    }
    end = block->offset() + block->stored_size();
    SIGHTLINE_TRY(check_size(*block, place));
    SIGHTLINE_TRY(check_known(*block, place));
    SIGHTLINE_TRY(check_rows(*container.manifest, *block, place));
  }
  return {};
}

std::string feature_name(const schema::Directory& directory, int bit) {
  for (const schema::Feature* feature : *directory.features()) {
    if (feature->is_required() && feature->bit() == bit) return feature->name()->str();
  }
  return "bit " + std::to_string(bit);
}

}  // namespace

std::string tile_place(std::int32_t x, std::int32_t y) {
  return "tile " + std::to_string(x) + "," + std::to_string(y);
}

Result<void> check_manifest(const schema::Manifest& manifest) {
  if (!is_aligned(*manifest.ranges_m()) || !is_aligned(*manifest.sensor()->beam_elevations_deg()) ||
      !is_aligned(*manifest.measurement()->offsets())) {
    return bad_manifest("a vector of 64-bit numbers is misaligned");
  }
  const schema::Vector3& origin_m = *manifest.origin_world_m();
  if (!std::isfinite(origin_m.x()) || !std::isfinite(origin_m.y()) ||
      !std::isfinite(origin_m.z())) {
    return bad_manifest("the frame's origin is not finite");
  }
  if (manifest.world() != nullptr && !is_world_name(manifest.world()->string_view())) {
    return bad_manifest("the name of its world is empty, not printable or too long");
  }
  if (!is_positive(manifest.cell_m()) || !is_positive(manifest.tile_m()) ||
      !is_positive(manifest.site_spacing_m()) || !is_positive(manifest.reach_m()) ||
      manifest.reach_m() > manifest.tile_m()) {
    return bad_manifest(
        "cell, tile, site spacing and reach must be positive, reach at most a tile");
  }
  const Numbers& ranges_m = *manifest.ranges_m();
  if (ranges_m.size() == 0 || ranges_m.size() > kMostRanges) {
    return bad_manifest("found " + std::to_string(ranges_m.size()) + " ranges");
  }
  if (!is_ascending_and_positive(ranges_m)) {
    return Error{ErrorCode::kBadOrder, "ranges are not positive and ascending", "", "manifest"};
  }
  SIGHTLINE_TRY(check_promises(*manifest.promises(), *manifest.quality()));
  SIGHTLINE_TRY(check_columns(manifest));
  if (manifest.size() > schema::MapSize::MAX) return bad_manifest("the size is unknown");
  return check_looks(manifest);
}

AnswerShape answer_shape(const schema::Manifest& manifest) {
  return {manifest.ranges_m()->size(), manifest.promises()->size(),
          manifest.looks() == nullptr ? 0 : manifest.looks()->size(),
          manifest.size() == schema::MapSize::Promise};
}

Result<void> check_features(const FileHeader& header, const schema::Directory& directory) {
  // Version 1 has no required features yet.
  for (int bit = 0; bit < 64; ++bit) {
    if (((header.incompatible_features >> bit) & 1) == 0) continue;
    return unknown_feature(concat("feature ", feature_name(directory, bit), " is required and"),
                           "byte 24");
  }
  return {};
}

Result<void> check_directory(const MapContainer& container) {
  std::uint64_t end = container.header.manifest_offset + container.header.manifest_size;
  const schema::Tile* previous = nullptr;
  for (const schema::Tile* tile : *container.directory->tiles()) {
    const std::string place = tile_place(tile->x(), tile->y());
    if (previous != nullptr &&
        !(std::pair(previous->x(), previous->y()) < std::pair(tile->x(), tile->y()))) {
      return Error{ErrorCode::kBadOrder, "tiles must ascend", "", place};
    }
    previous = tile;
    SIGHTLINE_TRY(check_blocks(container, *tile->layers(), place + " layer ", end));
  }
  SIGHTLINE_TRY(check_blocks(container, *container.directory->sections(), "section ", end));
  const std::uint64_t directory_end =
      container.header.directory_offset + container.header.directory_size;
  if (container.header.directory_offset - end >= kWidestGap ||
      container.file.size() - kTrailerSize - directory_end >= kWidestGap) {
    return Error{ErrorCode::kOutOfBounds, "there is a gap before or after the directory", "",
                 "byte " + std::to_string(container.header.directory_offset)};
  }
  return {};
}

}  // namespace sightline
