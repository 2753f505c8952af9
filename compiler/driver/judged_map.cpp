#include "compiler/driver/judged_map.h"

namespace sightline {
namespace {

template <class X>
void provide(const std::string& name, const X& artifact, ArtifactSet& artifacts) {
  artifacts.provide(name, artifact, sha256(to_bytes(artifact)));
}

}  // namespace

void aim_at_map(const CompiledMap& map, CompileConfig& config) {
  config.measure_error.ranges_m = map.predicted.ranges_m;
  config.track_drive.reach_m = map.reach_m;
  const bool is_same_recording =
      config.is_split() && config.evaluation.scans == config.mapping.scans;
  config.measure_error.scans = is_same_recording ? "odd" : "all";
}

void provide_map(const CompiledMap& map, ArtifactSet& artifacts) {
  provide("ndt-map", map.ndt, artifacts);
  provide("sites", map.sites, artifacts);
  provide("predicted-error", map.predicted, artifacts);
  provide("range-table", map.ranges, artifacts);
  provide("factor-table", map.factors, artifacts);
}

}  // namespace sightline
