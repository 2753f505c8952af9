#include "tests/bench/big_map.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <numeric>

#include "formats/base/check.h"
#include "formats/base/parallel.h"
#include "formats/base/random.h"
#include "formats/map/layers.h"
#include "formats/map/manifest.h"
#include "formats/map/map_writer.h"
#include "formats/reader/map_layout.h"
#include "map_generated.h"

namespace sightline {
namespace {

constexpr double kTile_m = 64.0;
constexpr std::uint32_t kSitesPerTile = 64;
constexpr int kNdsPerTile = 2000;
constexpr double kHeight_m = 24.0;  // of the space that NDs fill

CompiledMap frame_of_map() {
  CompiledMap map;
  map.map_id = "big-map";
  map.version = "bench";
  map.writer = "write_big_map";
  map.ndt.tile_m = kTile_m;
  map.sensor.beam_elevations_deg = {-15.0, 15.0};
  map.ranges.looks = every_return_at({10, 15, 20, 25, 30, 35, 40, 45, 50});
  map.ranges.promises.resize(2);
  map.ranges.promises[0].limit_m = 0.10;
  map.ranges.promises[1].limit_m = 0.25;
  map.predicted.looks = map.ranges.looks;
  map.predicted.limits_m = {0.10, 0.25};
  map.quality.resize(2);
  return map;
}

Nd random_nd(TileKey key, Random& random) {
  Nd nd;
  nd.mean_m = {kTile_m * (key.x + random.uniform()), kTile_m * (key.y + random.uniform()),
               kHeight_m * random.uniform()};
  nd.key = cell_key(nd.mean_m, NdtMap().cell_m);
  nd.point_count = 10 + static_cast<std::uint32_t>(random.below(1000));
  Eigen::Matrix3d root;
  for (int k = 0; k < 9; ++k) root(k / 3, k % 3) = random.uniform(-1.0, 1.0);
  nd.covariance_m2 = 0.1 * root * root.transpose();
  return nd;
}

// One ND in twenty is another one or gone, another has moved.
void change_nds(TileKey key, Random random, std::map<CellKey, Nd>& nds) {
  std::vector<CellKey> cells;
  for (const auto& [cell, nd] : nds) cells.push_back(cell);
  for (std::size_t i = 0; i < cells.size(); i += 20) {
    nds.erase(cells[i]);
    const Nd nd = random_nd(key, random);
    nds[nd.key] = nd;
    if (i + 1 == cells.size()) break;
    Nd& moved = nds[cells[i + 1]];
    moved.mean_m.z() += moved.mean_m.z() < (moved.key.z + 0.5) * NdtMap().cell_m ? 0.3 : -0.3;
  }
}

std::vector<std::byte> ndt_layer(TileKey key, bool is_changed, std::uint64_t seed,
                                 std::uint64_t& row_count) {
  Random random(seed);
  std::map<CellKey, Nd> nds;
  for (int i = 0; i < kNdsPerTile; ++i) {
    const Nd nd = random_nd(key, random);
    nds[nd.key] = nd;
  }
  if (is_changed) change_nds(key, random, nds);
  NdtMap ndt = frame_of_map().ndt;
  for (const auto& [cell, nd] : nds) ndt.nds.push_back(nd);
  std::vector<std::uint32_t> rows(ndt.nds.size());
  std::iota(rows.begin(), rows.end(), 0);
  row_count = rows.size();
  return encode_ndt_layer(ndt, rows);
}

// Errors fall with the range; a change adds to them, and the range follows.
void add_predictions(bool is_changed, Random& random, CompiledMap& map) {
  const double base_m = random.uniform(0.5, 2.5) * (is_changed ? 1.5 : 1.0);
  const std::size_t ranges = map.ranges.looks.size();
  std::vector<std::size_t> chosen(2, ranges - 1);
  for (std::size_t range = 0; range < ranges; ++range) {
    const double mean_m = base_m / map.ranges.looks[range].range_m + random.uniform(0.0, 0.005);
    map.predicted.mean_m.push_back(mean_m);
    for (std::size_t limit = 0; limit < 2; ++limit) {
      const double probability = 1.0 - std::exp(-2.0 * map.predicted.limits_m[limit] / mean_m);
      map.predicted.within_probability.push_back(probability);
      if (probability >= 0.9) chosen[limit] = std::min(chosen[limit], range);
    }
  }
  for (const std::size_t range : chosen) {
    map.ranges.range_index.push_back(static_cast<std::uint8_t>(range));
    map.ranges.flags.push_back(range + 1 == ranges ? kUnmet : 0);
    map.ranges.reasons.push_back(Reason::kModel);
  }
  map.predicted.extrapolated.insert(map.predicted.extrapolated.end(), ranges, 0);
  map.predicted.out_of_fold.push_back(1);
  map.predicted.has_history.push_back(0);
}

std::vector<std::byte> range_layer(TileKey key, bool is_changed, std::uint64_t seed,
                                   std::uint32_t first_site) {
  Random random(seed);
  CompiledMap map = frame_of_map();
  for (std::uint32_t i = 0; i < kSitesPerTile; ++i) {
    Site site;
    site.run = static_cast<std::uint32_t>(key.y);
    site.s_m = kTile_m * key.x + i;
    site.p_map_m = {kTile_m * key.x + i + 0.5, kTile_m * (key.y + 0.5), 1.8};
    site.T_map_vehicle.translation() = site.p_map_m - Eigen::Vector3d(0.0, 0.0, 1.8);
    map.sites.sites.push_back(site);
    add_predictions(is_changed, random, map);
  }
  std::vector<std::uint32_t> rows(kSitesPerTile);
  std::iota(rows.begin(), rows.end(), 0);
  std::vector<std::byte> raw = encode_range_layer(map, rows);
  const RangeLayout layout(kSitesPerTile, answer_shape(map));
  for (std::uint32_t& row : rows) row += first_site;
  std::memcpy(raw.data() + layout.site, rows.data(), rows.size() * sizeof rows[0]);
  return raw;
}

TileParts tile_parts(TileKey key, bool is_changed, std::uint64_t seed, std::uint32_t first_site) {
  TileParts tile;
  tile.key = key;
  std::uint64_t nds = 0;
  std::vector<std::byte> ndt = ndt_layer(key, is_changed, mix(seed, 1), nds);
  tile.layers.push_back(
      {std::string(kNdtLayer), kNdtLayerVersion, true, nds, true, std::move(ndt)});
  tile.layers.push_back({std::string(kRangeLayer), kRangeLayerVersion, true, kSitesPerTile, false,
                         range_layer(key, is_changed, mix(seed, 2), first_site)});
  return tile;
}

// The manifest of a map of one ND and one site, which claims that it has more.
std::vector<std::byte> manifest_with(std::uint64_t nds, std::uint32_t sites) {
  CompiledMap map = frame_of_map();
  map.ndt.nds.resize(1);
  map.sites.sites.resize(1);
  map.ranges.site_count = 1;
  std::vector<std::byte> bytes = encode_manifest(map);
  auto* table = flatbuffers::GetMutableRoot<flatbuffers::Table>(bytes.data());
  SIGHTLINE_CHECK(table->SetField(schema::Manifest::VT_ND_COUNT, nds, std::uint64_t{0}));
  SIGHTLINE_CHECK(table->SetField(schema::Manifest::VT_SITE_COUNT, sites, std::uint32_t{0}));
  return bytes;
}

}  // namespace

std::vector<std::byte> big_map(const BigMapOptions& options) {
  SIGHTLINE_CHECK(options.tile_count > 0 && options.tile_count <= 1 << 20);
  // As square as it gets; a street runs along x through each row of tiles.
  const int columns = static_cast<int>(std::ceil(std::sqrt(options.tile_count)));
  const int changed = static_cast<int>(std::lround(options.changed_share * options.tile_count));
  const int first_changed = options.tile_count / 3;
  ContainerParts parts;
  parts.tiles.resize(static_cast<std::size_t>(options.tile_count));
  parallel_for(parts.tiles.size(), 0, [&](std::size_t i) {
    const int number = static_cast<int>(i);
    const TileKey key{number / columns, number % columns};
    const bool is_changed = number >= first_changed && number < first_changed + changed;
    // Sites are numbered by run and place, that is by row of tiles.
    const int in_row =
        options.tile_count / columns + (key.y < options.tile_count % columns ? 1 : 0);
    int before = 0;
    for (int y = 0; y < key.y; ++y) {
      before += options.tile_count / columns + (y < options.tile_count % columns ? 1 : 0);
    }
    SIGHTLINE_CHECK(key.x < in_row);
    parts.tiles[i] = tile_parts(key, is_changed, mix(options.seed, i),
                                static_cast<std::uint32_t>(before + key.x) * kSitesPerTile);
  });
  std::uint64_t nds = 0;
  for (const TileParts& tile : parts.tiles) nds += tile.layers[0].row_count;
  parts.manifest =
      manifest_with(nds, static_cast<std::uint32_t>(parts.tiles.size()) * kSitesPerTile);
  return assemble(parts);
}

}  // namespace sightline
