#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

// What the gate says of a map: one check for each rule, and for each limit or place it was asked
// of.

namespace sightline {

enum class Severity : std::uint8_t { kNote, kWarning, kError };
std::string_view severity_name(Severity severity);  // "note", "warning", "error"

enum class Verdict : std::uint8_t {
  kMet,
  kViolated,
  kExcepted,   // violated, and an exception that has not expired covers the place
  kNotJudged,  // the map or the files given lack what the rule needs
};
std::string_view verdict_name(Verdict verdict);  // "met", "violated", "excepted", "not-judged"

// Sites of one run of a map, both ends included.
struct RouteStretch {
  bool is_of_old = false;  // numbers are those of the old map; the stretch is not in the new one
  std::uint32_t first_site = 0;
  std::uint32_t last_site = 0;
  std::uint32_t run = 0;
  double first_s_m = 0.0;
  double last_s_m = 0.0;
  // Of the site in its middle: where to look.
  Eigen::Vector3d middle_map_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d middle_world_m = Eigen::Vector3d::Zero();
};

struct Check {
  std::string rule;
  Severity severity = Severity::kError;
  Verdict verdict = Verdict::kMet;
  std::optional<double> limit_m;      // where the rule is asked of each limit
  std::optional<RouteStretch> place;  // none: the whole map
  double found = 0.0;                 // 0 where nothing was judged
  std::optional<double> allowed;      // none: no bound is set
  std::string unit;                   // "share", "m", "nat", "deg", "of the longest", ...
  std::string message;                // one sentence for people, without a full stop
  std::string exception;              // its reason and end, where one covers the place
};

// A map as findings name it.
struct GateMapCard {
  std::string file;
  std::string map_id;
  std::string version;
  std::uint64_t release = 0;
  std::string root_digest;  // hexadecimal
};

struct GateReport {
  GateMapCard map;
  // Where the rules stand, and its line with the section `gate` (1: there is none): what a person
  // can open and change. Empty: the rules are the program's own.
  std::string rules_file = {};
  std::size_t rules_line = 1;
  std::optional<GateMapCard> old_map;
  std::string today;                     // YYYY-MM-DD, the day that exceptions were judged on
  Severity fails_at = Severity::kError;  // the least severity of a violation that fails the gate
  std::vector<Check> checks;             // in the order of gate_rules()

  [[nodiscard]] std::size_t count(Verdict verdict) const;
  [[nodiscard]] std::size_t violations(Severity severity) const;
  [[nodiscard]] bool passes() const;
};

}  // namespace sightline
