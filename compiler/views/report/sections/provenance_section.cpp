#include <nlohmann/json.hpp>

#include "compiler/views/report/sections/sections.h"
#include "formats/base/hash.h"
#include "formats/text/quoted_text.h"

// What the provenance file beside the map holds, and the map's own facts.

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

Result<Json> provenance_of(const ReportSources& sources) {
  Json json = Json::parse(sources.provenance, nullptr, false);
  if (json.is_object()) return json;
  return Error{ErrorCode::kMalformedText, "the provenance beside the map is not a JSON object",
               sources.map_file + ".provenance.json"};
}

std::string text_of(const Json& value) {
  return value.is_string() ? value.get<std::string>() : value.dump();
}

double number_of(const Json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_number() ? found->get<double>() : 0.0;
}

std::string list_of(const Json& object, const char* name) {
  std::string text;
  const auto found = object.find(name);
  if (found == object.end() || !found->is_array()) return text;
  for (const Json& item : *found) text += (text.empty() ? "" : "; ") + text_of(item);
  return text;
}

std::string pass_table(const Json& passes) {
  TextGrid grid = {
      {"pass", "wall time (s)", "CPU time (s)", "peak memory (MiB)", "from the cache"}};
  double wall_s = 0.0;
  double cpu_s = 0.0;
  for (const Json& pass : passes) {
    wall_s += number_of(pass, "wall_s");
    cpu_s += number_of(pass, "cpu_s");
    grid.push_back({text_of(pass.value("name", Json(""))), fixed(number_of(pass, "wall_s"), 2),
                    fixed(number_of(pass, "cpu_s"), 2),
                    fixed(number_of(pass, "peak_memory_mib"), 0),
                    pass.value("from_cache", Json(false)) == Json(true) ? "yes" : ""});
  }
  grid.push_back({"all", fixed(wall_s, 2), fixed(cpu_s, 2), "", ""});
  return html_table(
      grid,
      "Time and memory of each pass in the compile that wrote this map; memory is the "
      "whole process's peak while the pass ran");
}

std::string warnings_of(const Json& passes) {
  std::string html;
  for (const Json& pass : passes) {
    const std::string warnings = list_of(pass, "warnings");
    if (warnings.empty()) continue;
    html += "<dt>" + xml_text(text_of(pass.value("name", Json("")))) + "</dt><dd>" +
            xml_text(warnings) + "</dd>\n";
  }
  return html.empty() ? "" : "<h3>Warnings</h3>\n<dl class=\"facts\">\n" + html + "</dl>\n";
}

std::string configuration_table(const Json& configuration) {
  TextGrid grid = {{"key", "value"}};
  for (const auto& [section, keys] : configuration.items()) {
    for (const auto& [key, value] : keys.items()) {
      grid.push_back({section + "." + key, text_of(value)});
    }
  }
  return "<details><summary>The effective configuration</summary>\n" +
         html_table(grid, "Every key, with the value that this compile used") + "</details>\n";
}

std::string model_table(const CompiledMap& map) {
  TextGrid grid = {{"fact", "value"}};
  for (const auto& [name, value] : map.model.card) grid.push_back({name, value});
  return "<details><summary>The error model's card</summary>\n" +
         html_table(grid, "What the error model was trained on, and what it is worth") +
         "</details>\n";
}

std::vector<std::pair<std::string, std::string>> map_facts(const ReportSources& sources) {
  const CompiledMap& map = *sources.map;
  std::string definitions;
  for (const NamedVersion& definition : map.definitions) {
    definitions += (definitions.empty() ? "" : ", ") + definition.name + " v" +
                   std::to_string(definition.version);
  }
  const bool is_simulated = map.measurement.reference == ErrorReference::kSimulated;
  return {{"map file", sources.map_file},
          {"map", map.map_id},
          {"version", map.version + ", release " + std::to_string(map.release)},
          {"written by", map.writer + ", format " + sources.summary.format},
          {"root digest", to_hex(sources.summary.root_digest)},
          {"model digest", to_hex(sources.summary.model_digest)},
          {is_simulated ? "finished map" : "mapping drive",
           map.measurement.mapping_drive + ", " + map.measurement.mapping_scans + " scans"},
          {"localization drive", is_simulated ? "none: errors were simulated"
                                              : map.measurement.localization_drive + ", " +
                                                    map.measurement.localization_scans + " scans"},
          {"localizing sensor", map.sensor.name},
          {"localizer that ranges and probabilities are for", to_text(map.model.localizer)},
          {"localizer that was measured", to_text(map.measurement.localizer)},
          {"definitions", definitions}};
}

}  // namespace

Result<Section> passes_section(const ReportSources& sources) {
  Section section = {"passes", "What it took", ""};
  if (sources.provenance.empty()) {
    section.html = paragraph("Not known: there is no provenance file beside the map.");
    return section;
  }
  SIGHTLINE_ASSIGN(const Json provenance, provenance_of(sources));
  const Json passes = provenance.value("passes", Json::array());
  section.html = pass_table(passes) + warnings_of(passes);
  return section;
}

Result<Section> provenance_section(const ReportSources& sources) {
  Section section = {"provenance", "Where it comes from", ""};
  std::vector<std::pair<std::string, std::string>> facts = map_facts(sources);
  std::string configuration;
  if (!sources.provenance.empty()) {
    SIGHTLINE_ASSIGN(const Json provenance, provenance_of(sources));
    for (const auto& [name, value] : provenance.items()) {
      if (name == "passes" || name == "configuration" || name == "inputs") continue;
      facts.emplace_back(
          name, name == "command_line" ? list_of(provenance, "command_line") : text_of(value));
    }
    const Json inputs = provenance.value("inputs", Json::object());
    for (const auto& [name, value] : inputs.items()) {
      facts.emplace_back("input " + name, text_of(value));
    }
    configuration = configuration_table(provenance.value("configuration", Json::object()));
  }
  section.html = fact_table(facts) + configuration + model_table(*sources.map);
  return section;
}

}  // namespace sightline
