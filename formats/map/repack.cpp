#include "formats/map/repack.h"

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <utility>

#include "formats/map/container_writer.h"
#include "formats/map/factor_layer.h"
#include "formats/map/map_reader.h"
#include "formats/map/packed_block.h"
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
  for (const PackedBlock& section : kept_blocks(container, *container.directory->sections(), keep)) {
    SIGHTLINE_CHECK(writer.add_section(section));
  }
  const Result<Digest> root = writer.finish();
  SIGHTLINE_CHECK(root && *root == header.root_digest);
  return file;
}

bool is_for_engineers(const PackedBlock& block) {
  constexpr std::array<std::string_view, 4> kNames = {kFactorLayer, "debug", kFactorNames,
                                                      kModelSection};
  return !block.is_required && std::ranges::find(kNames, block.name) != kNames.end();
}

struct FormatVersion {
  int major = 0;
  int minor = 0;
  auto operator<=>(const FormatVersion&) const = default;
};

std::string to_text(FormatVersion version) {
  return std::to_string(version.major) + "." + std::to_string(version.minor);
}

// One step of `migrate`; the steps lead from each version to the next.
struct MigrationStep {
  FormatVersion from;
  FormatVersion to;
  const char* what;
  Result<std::vector<std::byte>> (*apply)(const MapContainer& container);
};

// The writer adds what is derived.
Result<std::vector<std::byte>> add_derived(const MapContainer& container) {
  return repack(container, [](const PackedBlock&) { return true; });
}

constexpr std::array<MigrationStep, 1> kSteps = {{
    {{1, 0}, {1, 1}, "tiles tell their contents and sites can be looked up by place", &add_derived},
}};

constexpr FormatVersion kCurrent{kFormatMajor, kFormatMinor};
static_assert(kSteps.back().to.major == kFormatMajor && kSteps.back().to.minor == kFormatMinor);

FormatVersion version_of(const MapContainer& container) {
  return {container.header.major, container.header.minor};
}

Error newer_version(const MapContainer& container) {
  return {ErrorCode::kFutureVersion,
          "written by " + container.manifest->writer()->str() + ", format " +
              to_text(version_of(container)) + ", this program migrates " +
              to_text(kSteps.front().from) + " to " + to_text(kCurrent),
          "", "byte 8"};
}

}  // namespace

Result<Repacked> strip_map(std::span<const std::byte> file) {
  const Result<MapSummary> whole = verify_map(file);
  if (!whole) return whole.error();
  const Result<MapContainer> container = open_container(file);
  if (!container) return container.error();
  std::map<std::string, std::uint64_t> dropped;
  const auto keep = [&](const PackedBlock& block) {
    if (!is_for_engineers(block)) return true;
    dropped[block.name] += block.stored.size();
    return false;
  };
  Result<std::vector<std::byte>> stripped = repack(*container, keep);
  if (!stripped) return stripped.error();
  Repacked result{std::move(*stripped), {}};
  for (const auto& [name, bytes] : dropped) {
    result.told.push_back("dropped " + name + ", " + std::to_string(bytes) + " bytes");
  }
  if (dropped.empty()) result.told.emplace_back("there was nothing to drop");
  return result;
}

Result<Repacked> migrate_map(std::span<const std::byte> file) {
  const Result<MapSummary> whole = verify_map(file);
  if (!whole) return whole.error();
  Repacked result{{file.begin(), file.end()}, {}};
  for (const MigrationStep& step : kSteps) {
    const Result<MapContainer> container = open_container(result.file);
    if (!container) return container.error();
    if (version_of(*container) > kCurrent) return newer_version(*container);
    if (version_of(*container) != step.from) continue;
    Result<std::vector<std::byte>> next = step.apply(*container);
    if (!next) return next.error();
    result.file = std::move(*next);
    result.told.push_back(to_text(step.from) + " to " + to_text(step.to) + ": " + step.what);
  }
  if (result.told.empty()) result.told.push_back("it is of format " + to_text(kCurrent) + " already");
  return result;
}

}  // namespace sightline
