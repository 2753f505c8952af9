#pragma once

#include "compiler/views/report/report.h"
#include "passes/model/judge/evaluate_ranges.h"
#include "tests/formats/map/random_map.h"

namespace sightline {

struct MadeSources {
  CompiledMap map;
  MeasuredError measured;
  Evaluation evaluation;
  Trajectory trajectory;
  SurfacePoints points;
  Surface surface;
  DepthImages depth;

  [[nodiscard]] ReportSources sources() const {
    ReportSources all;
    all.map = &map;
    all.map_file = "made.slmap";
    all.provenance = R"({"program": "sightline", "passes": [{"name": "build-ndt", "wall_s": 1.25,
        "cpu_s": 2.5, "peak_memory_mib": 77.0, "warnings": ["3 cells < 10 points"]}],
        "configuration": {"build-ndt": {"cell_m": "2.0"}}, "inputs": {"mapping/recording": "ab12"}})";
    all.measured = &measured;
    all.evaluation = &evaluation;
    all.trajectory = &trajectory;
    all.points = &points;
    all.surface = &surface;
    all.depth = &depth;
    return all;
  }
};

inline MeasuredError measured_at(const CompiledMap& map) {
  MeasuredError measured;
  measured.drive = "evening";
  measured.looks = map.ranges.looks;
  measured.offsets = {{0.1, 0.2, 0.0, 0.01}};
  for (std::size_t site = 0; site < map.sites.sites.size(); ++site) {
    const bool has_scan = site % 7 != 3;
    measured.scan_of_site.push_back(has_scan ? static_cast<std::int64_t>(site) : -1);
    for (std::size_t range = 0; range < measured.looks.size(); ++range) {
      ErrorRow& row = measured.rows.emplace_back();
      if (!has_scan) continue;
      row.mean_m = map.predicted.mean(site, range) * (0.5 + 0.125 * static_cast<double>(site % 9));
      row.point_count = static_cast<std::uint32_t>(100 * (range + 1) + site);
      row.mean_time_ms = row.max_time_ms = 0.25 * static_cast<double>(range + 1);
      row.mean_work = row.max_work = 1000.0 * static_cast<double>(range + 1);
    }
  }
  return measured;
}

inline MadeSources made_sources(std::uint64_t seed) {
  RandomMapOptions options;
  options.seed = seed;
  options.site_count = 150;
  options.nd_count = 300;
  MadeSources made;
  made.map = random_map(options);
  made.map.factors.factors.back() = "virtual_points";
  made.measured = measured_at(made.map);
  PassContext ctx;
  made.evaluation = *evaluate_ranges(ctx, {}, made.map.sites, made.map.predicted, made.map.ranges,
                                     made.map.factors, made.measured);
  made.trajectory.poses.resize(3);
  made.points.voxel_m = 0.25;
  made.points.moved_voxels = {{-300, 5, 1}, {-300, 5, 2}, {4, 4, 0}};
  made.points.standing_count = 97;
  made.points.moving_count = 3;
  made.surface.cell_m = 0.5;
  made.surface.tile_m = 64.0;
  for (int i = 0; i < 40; ++i) {
    made.surface.patches.push_back({{i, 0, 0}, {0.5 * i + 0.25, 0.25, 0.5 * i}, {0, 0, 1}, 0.25});
  }
  made.depth.site_count = 150;
  for (std::size_t i = 0; i < made.depth.cells_per_site() * 150; ++i) {
    made.depth.distance_m.push_back(i % 5 == 0 ? std::numeric_limits<float>::infinity()
                                               : static_cast<float>(i % 500) / 10.0F);
  }
  return made;
}

}  // namespace sightline
