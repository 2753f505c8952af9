#include <algorithm>

#include "compiler/gate/rules/rules.h"

// Two maps: whether they are of one kind.

namespace sightline {
namespace {

// Counts differences and reports them.
class Differences {
 public:
  void add(const std::string& what, const std::string& before, const std::string& after) {
    if (before == after) return;
    ++count_;
    text_ += concat((text_.empty() ? "" : ", "), what, " ", before, " became ", after);
  }
  void add(const std::string& what, double before, double after) {
    add(what, format_double(before), format_double(after));
  }
  [[nodiscard]] std::vector<Found> found(const std::string& what) const {
    return of_whole_map(count_,
                        count_ == 0 ? what + " did not change" : concat(what, " changed: ", text_));
  }

 private:
  int count_ = 0;
  std::string text_;
};

std::string point_text(const Eigen::Vector3d& point_m) {
  return concat("(", format_double(point_m.x()), ", ", format_double(point_m.y()), ", ",
                format_double(point_m.z()), ")");
}

std::string list_text(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : " ") + format_double(value);
  return text;
}

std::vector<Found> find_frame(const GateInput& input, const Threshold&) {
  const CompiledMap& now = *input.map;
  const CompiledMap& old = *input.old_map;
  Differences differences;
  differences.add("origin", point_text(old.ndt.frame.origin_world_m),
                  point_text(now.ndt.frame.origin_world_m));
  differences.add("tile", old.ndt.tile_m, now.ndt.tile_m);
  differences.add("cell", old.ndt.cell_m, now.ndt.cell_m);
  differences.add("spacing of sites", old.sites.spacing_m, now.sites.spacing_m);
  differences.add("reach", old.reach_m, now.reach_m);
  return differences.found("the map's frame");
}

std::vector<Found> find_format(const GateInput& input, const Threshold&) {
  Differences differences;
  differences.add("version", input.old_format, input.format);
  return differences.found("the file format");
}

std::string version_of(const std::vector<NamedVersion>& definitions, const std::string& name) {
  const auto found = std::ranges::find(definitions, name, &NamedVersion::name);
  return found == definitions.end() ? "none" : concat("v", found->version);
}

std::vector<Found> find_definitions(const GateInput& input, const Threshold&) {
  Differences differences;
  for (const NamedVersion& definition : input.old_map->definitions) {
    differences.add(definition.name, concat("v", definition.version),
                    version_of(input.map->definitions, definition.name));
  }
  for (const NamedVersion& definition : input.map->definitions) {
    const std::string before = version_of(input.old_map->definitions, definition.name);
    if (before == "none") {
      differences.add(definition.name, before, concat("v", definition.version));
    }
  }
  return differences.found("the definitions");
}

std::string looks_text(const CompiledMap& map) {
  return map.looks ? to_text(map.looks->ranges.looks) : "none";
}

// Its threshold is set anew for every map.
std::string plan_text(const CompiledMap& map) {
  return map.looks && map.looks->ranges.plan ? to_text(*map.looks->ranges.plan) : "none";
}

std::vector<Found> find_limits(const GateInput& input, const Threshold&) {
  Differences differences;
  differences.add("limits", list_text(input.old_map->predicted.limits_m),
                  list_text(input.map->predicted.limits_m));
  differences.add("ranges", list_text(ranges_of(input.old_map->ranges.looks)),
                  list_text(ranges_of(input.map->ranges.looks)));
  differences.add("looks", looks_text(*input.old_map), looks_text(*input.map));
  differences.add("plan of looks", plan_text(*input.old_map), plan_text(*input.map));
  differences.add("rule", std::string(name_of(input.old_map->ranges.selection)),
                  std::string(name_of(input.map->ranges.selection)));
  return differences.found("limits, ranges or the rule of choice");
}

std::string model_text(const CompiledMap& map) { return to_hex(map.model.digest).substr(0, 12); }

// At a place that the model was trained on it predicts by the trees that did not see it.
std::string out_of_fold_text(const CompiledMap& map) {
  const auto count =
      std::ranges::count_if(map.predicted.out_of_fold, [](auto is) { return is != 0; });
  return concat(count, " of ", map.predicted.out_of_fold.size());
}

std::vector<Found> find_model(const GateInput& input, const Threshold&) {
  Differences differences;
  differences.add("model", model_text(*input.old_map), model_text(*input.map));
  differences.add("sites that it was trained on", out_of_fold_text(*input.old_map),
                  out_of_fold_text(*input.map));
  return differences.found("the error model");
}

std::vector<Found> find_sensor(const GateInput& input, const Threshold&) {
  const SensorProfile& now = input.map->sensor;
  const SensorProfile& old = input.old_map->sensor;
  Differences differences;
  differences.add("name", old.name, now.name);
  differences.add("beams", old.ring_count(), now.ring_count());
  differences.add("azimuth view", old.azimuth_view_deg, now.azimuth_view_deg);
  differences.add("least range", old.min_range_m, now.min_range_m);
  differences.add("greatest range", old.max_range_m, now.max_range_m);
  differences.add("height", old.height_m, now.height_m);
  differences.add("localizer", to_text(input.old_map->model.localizer),
                  to_text(input.map->model.localizer));
  return differences.found("the sensor or the localizer");
}

std::vector<Found> find_release(const GateInput& input, const Threshold&) {
  const auto growth =
      static_cast<double>(input.map->release) - static_cast<double>(input.old_map->release);
  return of_whole_map(growth, concat("the old map is release ", input.old_map->release,
                                     ", the new map is release ", input.map->release));
}

using enum Severity;
using enum Needs;
using enum Bound;

const GateRule kRules[] = {
    {"frame-change", kOldMap, kError, kAtMost, 0.0, "differences",
     "Origin, tile, cell, spacing of sites or reach differ: a vehicle's coordinates may no longer "
     "fit",
     find_frame},
    {"format-change", kOldMap, kWarning, kAtMost, 0.0, "differences",
     "The file has another format version", find_format},
    {"definition-change", kOldMap, kWarning, kAtMost, 0.0, "differences",
     "The numbers of the maps were computed by different definitions", find_definitions},
    {"limits-change", kOldMap, kError, kAtMost, 0.0, "differences",
     "Limits, ranges or the rule of choice differ", find_limits},
    {"model-change", kOldMap, kNote, kAtMost, 0.0, "differences",
     "The error model or its training sites differ: numbers may change where no street did",
     find_model},
    {"sensor-change", kOldMap, kWarning, kAtMost, 0.0, "differences",
     "The localizing sensor differs, or the localizer that ranges are for", find_sensor},
    {"release-order", kOldMap, kError, kAtLeast, 0.0, "releases",
     "Growth of the release counter, which may not fall", find_release},
};

}  // namespace

std::span<const GateRule> rules_of_identity() { return kRules; }

}  // namespace sightline
