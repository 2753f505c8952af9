// One look-up by a vehicle: a map of 200 km of route on a grid of streets, 200000 sites.

#include <benchmark/benchmark.h>

#include "formats/base/random.h"
#include "formats/map/container/packed_block.h"
#include "formats/map/map_writer.h"
#include "formats/reader/map_container.h"
#include "formats/reader/reader.h"
#include "map_generated.h"
#include "tests/formats/map/random_map.h"

namespace {

using namespace sightline;

// Streets 100 m apart in both directions, a site every metre.
CompiledMap city() {
  CompiledMap map;
  map.map_id = map.version = map.writer = "bench";
  map.sensor.beam_elevations_deg = {-15.0, 15.0};
  constexpr int kStreets = 100;
  for (int street = 0; street < 2 * kStreets; ++street) {
    for (int metre = 0; metre < 1000; ++metre) {
      const double along_m = metre;
      const double across_m = 100.0 * (street / 2 % 10) + 1000.0 * (street / 20);
      Site site;
      site.run = static_cast<std::uint32_t>(street);
      site.s_m = along_m;
      site.p_map_m = street % 2 == 0 ? Eigen::Vector3d(along_m, across_m, 1.8)
                                     : Eigen::Vector3d(across_m, along_m, 1.8);
      map.sites.sites.push_back(site);
    }
  }
  const std::size_t sites = map.sites.sites.size();
  map.ranges.looks = every_return_at({10, 15, 20, 25, 30, 35, 40, 45, 50});
  map.ranges.promises.resize(2);
  map.ranges.promises[0].limit_m = 0.10;
  map.ranges.promises[1].limit_m = 0.25;
  map.ranges.site_count = map.predicted.site_count = static_cast<std::uint32_t>(sites);
  map.ranges.range_index.resize(2 * sites, 3);
  map.ranges.flags.resize(2 * sites);
  map.ranges.reasons.resize(2 * sites, Reason::kModel);
  map.predicted.looks = map.ranges.looks;
  map.predicted.limits_m = {0.10, 0.25};
  map.predicted.mean_m.resize(9 * sites, 0.08);
  map.predicted.within_probability.resize(18 * sites, 0.9);
  map.predicted.extrapolated.resize(9 * sites);
  map.predicted.out_of_fold.resize(sites);
  map.predicted.has_history.resize(sites);
  map.quality.resize(2);
  return map;
}

// Places at most off_m beside any site, made beforehand: what is measured is the look-up alone.
std::vector<std::array<double, 3>> places(const CompiledMap& map, double off_m) {
  Random random(1);
  std::vector<std::array<double, 3>> places;
  for (int i = 0; i < 100000; ++i) {
    const Site& site = map.sites.sites[random.below(map.sites.sites.size())];
    places.push_back({site.p_map_m.x() + random.uniform(-off_m, off_m),
                      site.p_map_m.y() + random.uniform(-off_m, off_m), 1.8});
  }
  return places;
}

// As a map of this size.
std::vector<std::byte> file_of(CompiledMap map, MapSize size) {
  map.size = size;
  if (size == MapSize::kPromise) round_answers(map);
  return encode_map(map);
}

// Arguments: how far beside the street a position may be, m (200 finds no site every other time);
// 1: of a small map.
void look_up(benchmark::State& state) {
  static const CompiledMap kMap = city();
  static const std::array<std::vector<std::byte>, 2> kFiles = {file_of(kMap, MapSize::kFull),
                                                               file_of(kMap, MapSize::kPromise)};
  const std::vector<std::byte>& kFile = kFiles[static_cast<std::size_t>(state.range(1))];
  const Result<MapReader> reader = MapReader::open(kFile, "searching");
  const std::vector<std::array<double, 3>> positions =
      places(kMap, static_cast<double>(state.range(0)));
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(reader->observation_range(positions[i], 0.10)->range_m);
    i = i + 1 == positions.size() ? 0 : i + 1;
  }
  state.counters["sites"] = static_cast<double>(kMap.sites.sites.size());
  state.counters["file_MiB"] = static_cast<double>(kFile.size()) / (1 << 20);
}
BENCHMARK(look_up)->Args({1, 0})->Args({5, 0})->Args({200, 0})->Args({1, 1})->Args({5, 1});

// A tile of a small map: bytes of its unpacked layers. Argument: 0 its NDs, 1 its sites.
void decode(benchmark::State& state) {
  static const RandomMapOptions kTile{.site_count = 200,
                                      .nd_count = 2000,
                                      .tile_m = 256.0,
                                      .extent_m = 100.0,
                                      .size = MapSize::kPromise};
  const std::vector<std::byte> file = encode_map(random_map(kTile));
  const Result<MapContainer> container = open_container(file);
  std::vector<PackedBlock> layers;
  for (const schema::Tile* tile : *container->directory->tiles()) {
    for (PackedBlock& layer : packed_tile(*container, *tile).layers) {
      if (layer.codec == (state.range(0) == 0 ? BlockCodec::kNds : BlockCodec::kColumns)) {
        layers.push_back(std::move(layer));
      }
    }
  }
  std::size_t raw_bytes = 0;
  for (auto _ : state) {
    for (const PackedBlock& layer : layers) {
      raw_bytes += unpack(layer.codec, layer.stored, layer.row_count, layer.raw_size)->size();
    }
  }
  state.SetBytesProcessed(static_cast<std::int64_t>(raw_bytes));
}
BENCHMARK(decode)->Arg(0)->Arg(1);

void open_map(benchmark::State& state) {
  static const std::vector<std::byte> kFile = encode_map(city());
  for (auto _ : state) {
    const Result<MapReader> reader = MapReader::open(kFile, "searching");
    benchmark::DoNotOptimize(reader->info().site_count);
  }
}
BENCHMARK(open_map);

}  // namespace

BENCHMARK_MAIN();
