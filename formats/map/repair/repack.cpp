#include "formats/map/repair/repack.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <map>
#include <utility>

#include "formats/map/container/container_writer.h"
#include "formats/map/container/packed_block.h"
#include "formats/map/factor_layer.h"
#include "formats/map/map_reader.h"
#include "formats/reader/map_container.h"
#include "formats/reader/map_layout.h"
#include "map_generated.h"

namespace sightline {
namespace {

using Keep = std::function<bool(const PackedBlock&)>;

std::vector<PackedBlock> kept_blocks(const MapContainer& container, const auto& entries,
                                     const Keep& keep) {
  std::vector<PackedBlock> blocks;
  for (const schema::Block* entry : entries) {
    PackedBlock block = packed_block(container, *entry);
    if (!is_derived(block.name) && keep(block)) blocks.push_back(std::move(block));
  }
  return blocks;
}

// All of the directory's features but the one that the writer sets.
std::vector<FeatureParts> features_of(const MapContainer& container) {
  std::vector<FeatureParts> features;
  for (const schema::Feature* feature : *container.directory->features()) {
    if (!feature->is_required() && feature->bit() == kLookUpFeatureBit) continue;
    features.push_back({feature->bit(), feature->is_required(), feature->name()->str()});
  }
  return features;
}

Result<std::vector<std::byte>> repack(const MapContainer& container, const Keep& keep) {
  std::vector<std::byte> file;
  file.reserve(container.file.size());
  const FileHeader& header = container.header;
  const std::span<const std::byte> manifest =
      container.file.subspan(header.manifest_offset, header.manifest_size);
  ContainerWriter writer(write_to(file), {manifest.begin(), manifest.end()},
                         features_of(container));
  for (const schema::Tile* tile : *container.directory->tiles()) {
    const Result<void> added =
        writer.add_tile({tile->x(), tile->y()}, kept_blocks(container, *tile->layers(), keep));
    SIGHTLINE_CHECK(added);
  }
  for (const PackedBlock& section :
       kept_blocks(container, *container.directory->sections(), keep)) {
    SIGHTLINE_CHECK(writer.add_section(section));
  }
  const Result<Digest> root = writer.finish();
  SIGHTLINE_CHECK(root && *root == header.root_digest);
  return file;
}

bool is_for_engineers(const PackedBlock& block) {
  constexpr std::string_view kNames[] = {kFactorLayer,       kFactorNames, kSampleFactorLayer,
                                         kSampleFactorNames, "debug",      kModelSection};
  return !block.is_required && std::ranges::find(kNames, block.name) != std::end(kNames);
}

}  // namespace

Result<Repacked> strip_map(std::span<const std::byte> file) {
  SIGHTLINE_TRY(verify_map(file));
  SIGHTLINE_ASSIGN(const MapContainer container, open_container(file));
  std::map<std::string, std::uint64_t> dropped;
  const auto keep = [&](const PackedBlock& block) {
    if (!is_for_engineers(block)) return true;
    dropped[block.name] += block.stored.size();
    return false;
  };
  SIGHTLINE_ASSIGN(std::vector<std::byte> stripped, repack(container, keep));
  Repacked result{std::move(stripped), {}};
  for (const auto& [name, bytes] : dropped) {
    result.actions.push_back("dropped " + name + ", " + std::to_string(bytes) + " bytes");
  }
  if (dropped.empty()) result.actions.emplace_back("there was nothing to drop");
  return result;
}

}  // namespace sightline
