#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "compiler/gate/rules/rules.h"
#include "formats/base/result.h"

namespace sightline {

// Places that an exception covers; circle and box in the recording's world coordinates, which no
// change of the map's frame moves.
struct CirclePlace {
  Eigen::Vector2d centre_world_m = Eigen::Vector2d::Zero();
  double radius_m = 0.0;
};
struct BoxPlace {
  Eigen::Vector2d least_world_m = Eigen::Vector2d::Zero();
  Eigen::Vector2d greatest_world_m = Eigen::Vector2d::Zero();
};
struct RoutePlace {
  std::uint32_t run = 0;
  double from_s_m = 0.0;
  double to_s_m = 0.0;
};
struct WholeMap {};

struct GateException {
  std::string rule;               // an id, or "*"
  std::optional<double> limit_m;  // none: every limit
  std::variant<WholeMap, CirclePlace, BoxPlace, RoutePlace> place;
  std::string reason;
  std::string until;  // YYYY-MM-DD, the last day that it covers
};

// The settings of one rule; without a setting it is as in gate_rules().
struct RuleSetting {
  bool is_on = true;
  Severity severity = Severity::kError;
  Threshold threshold;
};

struct GateSettings {
  double stretch_m = 100.0;
  double change_stretch_m = 20.0;
  Severity fails_at = Severity::kError;      // the least severity that fails the gate
  std::map<std::string, RuleSetting> rules;  // every rule, by its id
  std::vector<GateException> exceptions;
};

GateSettings default_gate_settings();

// The section `gate` of a YAML file, or the whole of a file that has no such section and no other
// section of a configuration (schemas/gate_rules.md). Errors: file-not-found, cannot-open,
// cannot-read, malformed-text, unknown-key (with the nearest name), bad-value, missing-key.
Result<GateSettings> read_gate_settings(const std::filesystem::path& file);
Result<GateSettings> parse_gate_settings(const std::string& yaml);

// JSON Schema (draft 7) of the section.
std::string gate_settings_schema();

// YYYY-MM-DD of a day that exists.
bool is_date(std::string_view text);
// Days from one such date to another.
int days_between(std::string_view from, std::string_view to);

}  // namespace sightline
