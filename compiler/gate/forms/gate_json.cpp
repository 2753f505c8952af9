#include <nlohmann/json.hpp>

#include "compiler/gate/forms/gate_text.h"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

Json card_json(const GateMapCard& card) {
  return {{"file", card.file},
          {"map_id", card.map_id},
          {"version", card.version},
          {"release", card.release},
          {"root_digest", card.root_digest}};
}

Json point_json(const Eigen::Vector3d& p_m) { return Json::array({p_m.x(), p_m.y(), p_m.z()}); }

Json place_json(const RouteStretch& place) {
  return {{"of_old_map", place.is_of_old},
          {"first_site", place.first_site},
          {"last_site", place.last_site},
          {"run", place.run},
          {"first_s_m", place.first_s_m},
          {"last_s_m", place.last_s_m},
          {"middle_map_m", point_json(place.middle_map_m)},
          {"middle_world_m", point_json(place.middle_world_m)}};
}

Json check_json(const Check& check) {
  Json json = {{"rule", check.rule},
               {"severity", severity_name(check.severity)},
               {"verdict", verdict_name(check.verdict)},
               {"limit_m", nullptr},
               {"found", check.found},
               {"allowed", nullptr},
               {"unit", check.unit},
               {"place", nullptr},
               {"message", check.message}};
  if (check.limit_m) json["limit_m"] = *check.limit_m;
  if (check.allowed) json["allowed"] = *check.allowed;
  if (check.place) json["place"] = place_json(*check.place);
  if (!check.exception.empty()) json["exception"] = check.exception;
  return json;
}

}  // namespace

std::string to_json(const GateReport& report) {
  Json json = {{"schema", 1},
               {"map", card_json(report.map)},
               {"old_map", nullptr},
               {"today", report.today},
               {"passed", report.passes()},
               {"fails_at", severity_name(report.fails_at)},
               {"errors", report.violations(Severity::kError)},
               {"warnings", report.violations(Severity::kWarning)},
               {"notes", report.violations(Severity::kNote)},
               {"excepted", report.count(Verdict::kExcepted)},
               {"checks", Json::array()}};
  if (report.old_map) json["old_map"] = card_json(*report.old_map);
  for (const Check& check : report.checks) json["checks"].push_back(check_json(check));
  return json.dump(2) + "\n";
}

}  // namespace sightline
