#include "formats/map/block_decoder.h"

#include <algorithm>

#include "formats/map/drives_section.h"
#include "formats/map/factor_layer.h"
#include "formats/map/layers.h"
#include "map_generated.h"

namespace sightline {

BlockDecoder::BlockDecoder(std::size_t site_count, CompiledMap& map)
    : map_(map), is_filled_(site_count) {
  make_room_for_sites(site_count, map);
}

void BlockDecoder::expect(const MapContainer& container, std::string_view names,
                          std::string_view layer, const std::vector<Look>& looks) {
  const schema::Block* section = find_section(container, names);
  if (section == nullptr || section->version() != kFactorNamesVersion) return;
  if (section->row_count() == 0 || section->row_count() > kMostFactors) return;
  ExpectedFactors& expected = factors_.emplace_back();
  expected.names = names;
  expected.layer = layer;
  expected.is_filled.resize(is_filled_.size());
  expected.table.looks = looks;
  expected.table.factors.resize(section->row_count());
  expected.table.site_count = map_.ranges.site_count;
  expected.table.values.resize(expected.table.shape().size(is_filled_.size()));
}

void BlockDecoder::expect_factors(const MapContainer& container) {
  expect(container, kFactorNames, kFactorLayer, map_.ranges.looks);
  if (!map_.looks) return;
  expect(container, kSampleFactorNames, kSampleFactorLayer, map_.looks->ranges.looks);
}

Result<void> BlockDecoder::decode_layer(const PackedBlock& block, std::span<const std::byte> raw,
                                        TileKey key) {
  if (block.name == kNdtLayer) return decode_ndt_layer(raw, block.row_count, key, map_.ndt);
  if (block.name == kRangeLayer) {
    return decode_range_layer(raw, block.row_count, key, map_, is_filled_);
  }
  if (block.version != kFactorLayerVersion) return {};
  for (ExpectedFactors& expected : factors_) {
    if (block.name != expected.layer) continue;
    SIGHTLINE_TRY(decode_factor_layer(raw, block.row_count, expected.table, expected.is_filled));
  }
  return {};
}

Result<void> BlockDecoder::decode_section(const PackedBlock& block,
                                          std::span<const std::byte> raw) {
  for (ExpectedFactors& expected : factors_) {
    if (block.name == expected.names) return decode_factor_names(raw, expected.table);
  }
  if (block.name == kDrivesSection && knows_drives_section(block.version)) {
    SIGHTLINE_ASSIGN(map_.tile_drives, decode_drives(raw, block.version, block.row_count));
  }
  if (block.name == kRecordingsSection && block.version == kRecordingsSectionVersion) {
    SIGHTLINE_ASSIGN(map_.recordings, decode_recordings(raw, block.row_count));
  }
  if (block.name != kModelSection) return {};
  if (sha256(raw) != map_.model.digest) return wrong_digest("the error model", "");
  map_.model.bytes.assign(raw.begin(), raw.end());
  return {};
}

Result<void> BlockDecoder::check_factors() const {
  for (const ExpectedFactors& expected : factors_) {
    if (std::ranges::find(expected.is_filled, false) == expected.is_filled.end()) continue;
    return Error{ErrorCode::kBadLayer, "the map lists factors, but some sites have none", "",
                 "layer " + std::string(expected.layer)};
  }
  return {};
}

void BlockDecoder::take_factors() {
  for (ExpectedFactors& expected : factors_) {
    if (expected.layer == kFactorLayer) map_.factors = std::move(expected.table);
  }
  for (ExpectedFactors& expected : factors_) {
    if (expected.layer != kSampleFactorLayer || map_.factors.factors.empty()) continue;
    map_.looks->factors = std::move(expected.table);
  }
}

}  // namespace sightline
