#include "formats/map/diff/diff_facts.h"

#include <algorithm>

namespace sightline {
namespace {

using Facts = std::vector<std::pair<std::string, std::string>>;

std::string text_of(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : " ") + format_double(value);
  return text;
}

std::string text_of(bool value) { return value ? "yes" : "no"; }

std::string digest_of(const SensorProfile& sensor) {
  ByteWriter writer;
  encode(sensor, writer);
  return to_hex(sha256(writer.bytes()));
}

std::string digest_of(const std::vector<InitialOffset>& offsets) {
  ByteWriter writer;
  for (const InitialOffset& offset : offsets) {
    for (const double value : {offset.x_m, offset.y_m, offset.z_m, offset.yaw_rad}) {
      writer.put(value);
    }
  }
  return std::to_string(offsets.size()) + ", sha256 " + to_hex(sha256(writer.bytes()));
}

// `of`: "promise.", or "look_promise." of the looks that take a sample.
void add_promises(const RangeTable& ranges, const std::string& of, Facts& facts) {
  for (const LimitPromise& promise : ranges.promises) {
    const std::string name = of + format_double(promise.limit_m) + "_m.";
    facts.emplace_back(name + "method", promise.method);
    facts.emplace_back(name + "is_earned", text_of(promise.is_earned));
    facts.emplace_back(name + "scope", std::string(promise_scope_name(promise.scope)));
    facts.emplace_back(name + "alpha", format_double(promise.alpha));
    facts.emplace_back(name + "delta", format_double(promise.delta));
    facts.emplace_back(name + "probability_threshold",
                       format_double(promise.probability_threshold));
    facts.emplace_back(name + "history_threshold", format_double(promise.history_threshold));
    facts.emplace_back(name + "block_count", std::to_string(promise.block_count));
    facts.emplace_back(name + "place_count", std::to_string(promise.place_count));
    facts.emplace_back(name + "drive_count", std::to_string(promise.drive_count));
    facts.emplace_back(name + "statement", promise.statement);
  }
}

void add_measurement(const CompiledMap& map, Facts& facts) {
  const MeasurementCard& card = map.measurement;
  const bool is_known = card.reference == ErrorReference::kKnownPose;
  const bool is_simulated = card.reference == ErrorReference::kSimulated;
  facts.emplace_back("sensor.name", map.sensor.name);
  facts.emplace_back("sensor.digest", digest_of(map.sensor));
  facts.emplace_back("measurement.mapping_drive", card.mapping_drive);
  facts.emplace_back("measurement.mapping_scans", card.mapping_scans);
  facts.emplace_back("measurement.localization_drive", card.localization_drive);
  facts.emplace_back("measurement.localization_scans", card.localization_scans);
  facts.emplace_back("measurement.reference", is_known       ? "known poses"
                                              : is_simulated ? "simulated"
                                                             : "full-range match");
  facts.emplace_back("measurement.localizer", to_text(card.localizer));
  facts.emplace_back("measurement.offsets", digest_of(card.offsets));
  facts.emplace_back("measurement.measured_site_count", std::to_string(card.measured_site_count));
}

void add_look_coverage(const CompiledMap& map, Facts& facts) {
  for (std::size_t limit = 0; limit < map.look_quality.size(); ++limit) {
    const std::string name =
        "look_coverage." + format_double(map.ranges.promises[limit].limit_m) + "_m.";
    const LimitQuality& quality = map.look_quality[limit];
    facts.emplace_back(name + "expected", format_double(quality.expected_coverage));
    facts.emplace_back(name + "measured", format_double(quality.measured_coverage));
  }
}

Facts facts_of(const CompiledMap& map) {
  const Eigen::Vector3d& origin_m = map.ndt.frame.origin_world_m;
  std::vector<double> limits_m;
  for (const LimitPromise& promise : map.ranges.promises) limits_m.push_back(promise.limit_m);
  Facts facts = {{"map_id", map.map_id},
                 {"version", map.version},
                 {"release", std::to_string(map.release)},
                 {"writer", map.writer},
                 {"frame.origin_world_m", text_of({origin_m.x(), origin_m.y(), origin_m.z()})},
                 {"frame.world", map.world},
                 {"cell_m", format_double(map.ndt.cell_m)},
                 {"tile_m", format_double(map.ndt.tile_m)},
                 {"point_count", std::to_string(map.ndt.point_count)},
                 {"site_spacing_m", format_double(map.sites.spacing_m)},
                 {"reach_m", format_double(map.reach_m)},
                 {"ranges_m", text_of(ranges_of(map.ranges.looks))},
                 {"limits_m", text_of(limits_m)},
                 {"rule", std::string(selection_name(map.ranges.selection))},
                 {"dilation_m", format_double(map.ranges.dilation_m)}};
  add_promises(map.ranges, "promise.", facts);
  for (const RangeTable& looks : map.ranges.of_samples) {
    facts.emplace_back("looks", to_text(looks.looks));
    facts.emplace_back("look_plan", looks.plan ? to_text(*looks.plan) : "none");
    if (looks.plan) {
      facts.emplace_back("look_plan.doubt_above", format_double(looks.plan->doubt_above));
    }
    add_promises(looks, "look_promise.", facts);
    add_look_coverage(map, facts);
  }
  add_measurement(map, facts);
  for (const NamedVersion& definition : map.definitions) {
    facts.emplace_back("definitions." + definition.name, "v" + std::to_string(definition.version));
  }
  facts.emplace_back("model.encoding_version", std::to_string(map.model.encoding_version));
  facts.emplace_back("model.localizer", to_text(map.model.localizer));
  facts.emplace_back("model.digest", to_hex(map.model.digest));
  if (map.sharpness) {
    facts.emplace_back("sharpness.mean_entropy_nat",
                       format_double(map.sharpness->of_map.mean_entropy_nat));
  }
  return facts;
}

const std::string* find(const Facts& facts, const std::string& name) {
  const auto found = std::find_if(facts.begin(), facts.end(),
                                  [&](const auto& fact) { return fact.first == name; });
  return found == facts.end() ? nullptr : &found->second;
}

}  // namespace

std::vector<FactDiff> diff_facts(const CompiledMap& before, const CompiledMap& after) {
  const Facts old_facts = facts_of(before);
  const Facts new_facts = facts_of(after);
  std::vector<FactDiff> changes;
  for (const auto& [name, value] : old_facts) {
    const std::string* now = find(new_facts, name);
    if (now == nullptr || *now != value) {
      changes.push_back({name, value, now == nullptr ? "" : *now});
    }
  }
  for (const auto& [name, value] : new_facts) {
    if (find(old_facts, name) == nullptr) changes.push_back({name, "", value});
  }
  return changes;
}

}  // namespace sightline
