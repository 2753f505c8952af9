// How much memory does linking a map of many kilometres take? A map of a street is laid behind
// itself again and again, by its numbers alone: nothing is driven. Its artifacts are written as a
// cluster's store holds them; then they are read back and the map file is made of them, as
// `sightline link` does, while the largest memory of the process is counted.
//
// usage: link_memory MAP.slmap COPIES [OUTPUT.slmap]

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "compiler/pipeline/process_cost.h"
#include "formats/base/files/atomic_file.h"
#include "formats/base/files/stored_bytes.h"
#include "formats/map/map_reader.h"
#include "passes/emit/emit_map.h"

namespace sightline {
namespace {

template <class Value>
void repeat(std::vector<Value>& values, int copies) {
  const std::vector<Value> once = values;
  values.clear();
  values.reserve(once.size() * static_cast<std::size_t>(copies));
  for (int copy = 0; copy < copies; ++copy) values.insert(values.end(), once.begin(), once.end());
}

void repeat(FactorTable& factors, int copies) {
  factors.site_count *= static_cast<std::uint32_t>(copies);
  repeat(factors.values, copies);
}

void repeat(PredictedError& predicted, int copies) {
  predicted.site_count *= static_cast<std::uint32_t>(copies);
  repeat(predicted.mean_m, copies);
  repeat(predicted.within_probability, copies);
  repeat(predicted.extrapolated, copies);
  repeat(predicted.out_of_fold, copies);
  repeat(predicted.has_history, copies);
}

void repeat(RangeTable& ranges, int copies) {
  ranges.site_count *= static_cast<std::uint32_t>(copies);
  repeat(ranges.range_index, copies);
  repeat(ranges.flags, copies);
  repeat(ranges.reasons, copies);
}

// Whole tiles farther along x with each copy.
void repeat(NdtMap& ndt, Sites& sites, int copies) {
  const auto [west, east] =
      std::ranges::minmax_element(ndt.nds, {}, [](const Nd& nd) { return nd.key.x; });
  const auto cells_of_tile = static_cast<std::int32_t>(ndt.tile_m / ndt.cell_m);
  const std::int32_t step = ((east->key.x - west->key.x) / cells_of_tile + 2) * cells_of_tile;
  const std::vector<Nd> nds = std::exchange(ndt.nds, {});
  const std::vector<Site> all = std::exchange(sites.sites, {});
  for (int copy = 0; copy < copies; ++copy) {
    const double along_m = copy * step * ndt.cell_m;
    for (Nd nd : nds) {
      nd.key.x += copy * step;
      nd.mean_m.x() += along_m;
      ndt.nds.push_back(nd);
    }
    for (Site site : all) {
      site.run += static_cast<std::uint32_t>(copy) * (all.back().run + 1);
      site.p_map_m.x() += along_m;
      site.T_map_vehicle.translation().x() += along_m;
      sites.sites.push_back(site);
    }
  }
  std::ranges::sort(ndt.nds, {}, [&](const Nd& nd) {
    return std::pair(tile_of(nd.key, ndt.cell_m, ndt.tile_m), nd.key);
  });
}

Drive drive_along(const CompiledMap& map) {
  Drive drive;
  drive.name = "made-up";
  drive.sensor = map.sensor;
  drive.frame = map.ndt.frame;
  for (const Site& site : map.sites.sites) {
    const auto number = static_cast<std::uint32_t>(drive.scans.size());
    ScanInfo scan;
    scan.recording_index = number;
    scan.stamp_ns = std::int64_t{number} * 100'000'000;
    scan.source = std::to_string(1'000'000 + number) + ".pcd";
    scan.point_count = 20'000;
    scan.T_world_vehicle = site.T_map_vehicle;
    drive.scans.push_back(scan);
  }
  return drive;
}

Trajectory trajectory_along(const CompiledMap& map) {
  Trajectory trajectory;
  trajectory.frame = map.ndt.frame;
  for (const Site& site : map.sites.sites) {
    const auto number = static_cast<std::uint32_t>(trajectory.poses.size());
    trajectory.poses.push_back({number, std::int64_t{number} * 100'000'000, site.T_map_vehicle});
  }
  return trajectory;
}

MeasuredError measured_of(const RangeTable& ranges, const MeasurementCard& card) {
  MeasuredError measured;
  measured.drive = "made-up";
  measured.matching.localizer = card.localizer;
  measured.looks = ranges.looks;
  measured.offsets = card.offsets;
  for (std::uint32_t i = 0; i < ranges.site_count; ++i) measured.scan_of_site.push_back(i);
  measured.rows.resize(measured.shape().size(ranges.site_count));
  return measured;
}

ByFamily<MeasuredError> measured_of(const ByFamily<RangeTable>& ranges,
                                    const MeasurementCard& card) {
  ByFamily<MeasuredError> both(measured_of(ranges.ranges, card));
  if (ranges.samples) both.samples = measured_of(*ranges.samples, card);
  return both;
}

StoredBytes in_file(std::span<const std::byte> bytes) {
  GrowingBytes file(0);
  if (!file.append(bytes)) std::exit(EXIT_FAILURE);
  return file.take();
}

template <class X>
StoredBytes stored(const X& artifact) {
  return in_file(to_bytes(artifact));
}

template <class X>
X loaded(const StoredBytes& bytes) {
  return *from_bytes<X>(*bytes.read(0, bytes.size()));
}

int run(const std::string& file, int copies, const std::string& output) {
  return_freed_memory();
  Result<CompiledMap> read = read_map(file);
  if (!read) {
    std::fprintf(stderr, "%s\n", to_string(read.error()).c_str());
    return EXIT_FAILURE;
  }
  CompiledMap& map = *read;
  // As large as it is: a model of more route would grow with it, but lie packed as well.
  const PackedModel model = *pack_model(map.model);
  const RecordingCards recordings = map.recordings.value_or(RecordingCards{});
  repeat(map.ndt, map.sites, copies);
  repeat(map.predicted, copies);
  repeat(map.ranges, copies);
  repeat(map.factors, copies);
  if (map.looks) {
    repeat(map.looks->predicted, copies);
    repeat(map.looks->ranges, copies);
    repeat(map.looks->factors, copies);
  }
  const StoredBytes sites = stored(map.sites);
  const StoredBytes predicted = stored(predicted_of(map));
  const StoredBytes ranges = stored(choice_of(map));
  const StoredBytes factors = stored(factors_of(map));
  const StoredBytes measured = stored(measured_of(choice_of(map), map.measurement));
  const StoredBytes drive = stored(drive_along(map));
  const StoredBytes trajectory = stored(trajectory_along(map));
  GrowingBytes packed(0);
  const Result<PackedNds> nds = pack_nds(map.ndt);
  if (!nds || !visit_bytes(*nds, [&](auto piece) { return packed.append(piece); }))
    return EXIT_FAILURE;
  const StoredBytes packed_nds = packed.take();
  std::printf("%zu sites, %zu NDs, artifacts of %.0f MiB\n", map.sites.sites.size(),
              map.ndt.nds.size(),
              static_cast<double>(sites.size() + predicted.size() + ranges.size() + factors.size() +
                                  measured.size() + 2 * drive.size() + trajectory.size() +
                                  packed_nds.size()) /
                  (1 << 20));
  map = {};
  reset_peak_memory();
  std::printf("before: %.0f MiB\n", peak_memory_mib());
  const double begin_s = process_cpu_s();
  const auto own_measured = *from_stored<ByFamily<StoredTable<MeasuredError>>>(measured);
  const auto own_ranges = loaded<ByFamily<RangeTable>>(ranges);
  const auto own_factors = *from_stored<ByFamily<StoredTable<FactorTable>>>(factors);
  const Sites own_sites = loaded<Sites>(sites);
  const auto own_predicted = loaded<ByFamily<PredictedError>>(predicted);
  const Drive mapping = loaded<Drive>(drive);
  const Trajectory own_trajectory = loaded<Trajectory>(trajectory);
  const PackedNds own_nds = *from_stored<PackedNds>(packed_nds);
  std::printf("read: %.0f MiB\n", peak_memory_mib());
  PassContext ctx;
  const Result<MapFile> linked = emit_map(ctx, {},
                                          {.nds = own_nds,
                                           .sites = own_sites,
                                           .predicted = own_predicted,
                                           .ranges = own_ranges,
                                           .measured = own_measured,
                                           .model = model,
                                           .factors = own_factors,
                                           .sensor = mapping.sensor,
                                           .recordings = recordings,
                                           .mapping = &mapping,
                                           .trajectory = &own_trajectory});
  if (!linked) {
    std::fprintf(stderr, "%s\n", to_string(linked.error()).c_str());
    return EXIT_FAILURE;
  }
  std::printf("linked: %.0f MiB at most, %.1f s of CPU, a file of %.0f MiB\n", peak_memory_mib(),
              process_cpu_s() - begin_s, static_cast<double>(linked->bytes.size()) / (1 << 20));
  if (output.empty()) return EXIT_SUCCESS;
  const auto write = [&](const ByteSink& sink) { return linked->bytes.visit(sink); };
  const Result<void> written = write_file_atomically(output, write, IfExists::kReplace);
  if (!written) std::fprintf(stderr, "%s\n", to_string(written.error()).c_str());
  return written ? EXIT_SUCCESS : EXIT_FAILURE;
}

}  // namespace
}  // namespace sightline

int main(int argc, char** argv) {
  const int copies = argc == 3 || argc == 4 ? std::atoi(argv[2]) : 0;
  if (copies < 1) {
    std::fprintf(stderr, "usage: link_memory MAP.slmap COPIES [OUTPUT.slmap]\n");
    return EXIT_FAILURE;
  }
  return sightline::run(argv[1], copies, argc == 4 ? argv[3] : "");
}
