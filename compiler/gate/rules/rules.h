#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/views/verdict/verdict.h"
#include "formats/base/result.h"
#include "formats/map/compiled_map.h"

// The rules of the gate (schemas/gate_rules.md): pure functions over a compiled map, an old one
// beside it, and what a drive observed in it.

namespace sightline {

// The map's ranges on a drive at one limit (RuleScore of the map's own rule).
struct ObservedLimit {
  double limit_m = 0.0;
  double coverage = 0.0;
  double mean_range_m = 0.0;
  double time_ratio = 0.0;  // to the longest range
  double work_ratio = 0.0;
  double worst_coverage = 0.0;  // of the worst stretch
  std::uint32_t worst_begin_site = 0;
  double answered_coverage = 0.0;  // of the answered sites; `coverage` where the file has no such
};

// One kind of the map's answers on the drive, at one limit.
struct ObservedAnswer {
  std::string by;  // "plan", "look" or "map": its range
  double limit_m = 0.0;
  double coverage = 0.0;         // of the sites, or of the scans of the replayed drive
  double time_ratio = 0.0;       // to the longest range everywhere
  std::uint32_t lost_count = 0;  // tracks; 0 at sites
};

// The figures in the JSON of `sightline evaluate` that the gate judges.
struct Observation {
  std::string drive;
  std::uint32_t site_count = 0;  // of the map
  double stretch_m = 0.0;        // length of the worst stretch
  std::vector<ObservedLimit> limits;
  std::vector<ObservedAnswer> looks = {};     // at the sites; empty: the map has no looks
  std::vector<ObservedAnswer> replayed = {};  // along the drive; empty: it was not replayed
  DriveOrigin origin = DriveOrigin::kOther;
  std::string root_digest = {};  // of the map that was judged; empty: the file does not say
};

// Errors: file-not-found, cannot-open, cannot-read, malformed-text (not that JSON).
Result<Observation> read_observation(const std::filesystem::path& file);
Result<Observation> parse_observation(std::string_view json);

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

// A result of the gate: one for each rule, and for each limit or place that it judged.
struct Check {
  std::string rule;
  Severity severity = Severity::kError;
  Verdict verdict = Verdict::kMet;
  std::optional<double> limit_m;      // where the rule judges each limit
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
  // The file of the rules and its line with the section `gate` (1: there is none), which a user can
  // open and change. Empty: the rules are the program's own.
  std::string rules_file = {};
  std::size_t rules_line = 1;
  std::optional<GateMapCard> old_map;
  std::string today;                     // YYYY-MM-DD, the day that exceptions were judged on
  Severity fails_at = Severity::kError;  // the least severity of a violation that fails the gate
  MapJudgement verdict = {};             // of the map, which no rule changes
  std::vector<Check> checks;             // in the order of gate_rules()

  [[nodiscard]] std::size_t count(Verdict wanted) const;
  [[nodiscard]] std::size_t violations(Severity severity) const;
  [[nodiscard]] bool passes() const;
};

// Which sites of two maps are the same place: each site's nearest of the other map, by the sensor's
// origin in world coordinates and within that map's reach, the lower number on a tie: what a
// vehicle would read there.
struct SitePairs {
  std::vector<std::optional<std::uint32_t>> old_of_new;  // [site of the new map]
  std::vector<std::optional<std::uint32_t>> new_of_old;  // [site of the old map]
};

SitePairs pair_sites(const CompiledMap& new_map, const CompiledMap& old_map);

// The inputs of a rule. The old map and the observation may be missing.
struct GateInput {
  const CompiledMap* map = nullptr;
  std::string format;  // of the map file, "1.0"
  const CompiledMap* old_map = nullptr;
  std::string old_format;
  SitePairs pairs;  // of the sites of both maps, where there is an old one
  const Observation* observation = nullptr;
  double stretch_m = 100.0;        // route that is judged at a time in one map
  double change_stretch_m = 20.0;  // and in the change between two
};

// On which side of the threshold a number may lie.
enum class Bound : std::uint8_t { kAtLeast, kAtMost };

// The threshold of a rule, and where it differs for single limits.
struct Threshold {
  std::optional<double> allowed;  // none: the rule reports the number and judges nothing
  std::vector<std::pair<double, double>> at_limits;  // limit_m, allowed
  [[nodiscard]] std::optional<double> at(std::optional<double> limit_m) const;
};

// What a rule found, of the whole map or of one place.
struct Found {
  std::optional<double> limit_m;
  std::optional<RouteStretch> place;
  double value = 0.0;
  std::string message;   // a sentence without the threshold
  bool is_known = true;  // false: not judged, for the reason that the message gives
};

using RuleFunction = std::vector<Found> (*)(const GateInput& input, const Threshold& threshold);

enum class Needs : std::uint8_t { kMap, kObservation, kOldMap, kExceptions };

struct GateRule {
  std::string_view id;  // stable: "expected-coverage"
  Needs needs = Needs::kMap;
  Severity severity = Severity::kError;  // unless the settings say otherwise
  Bound bound = Bound::kAtMost;
  std::optional<double> allowed;  // unless the settings say otherwise
  std::string_view unit;
  std::string_view summary;     // what is judged, for people: a sentence without a full stop
  RuleFunction find = nullptr;  // nullptr: the gate itself finds it (exceptions)
};

// Every rule, in the order in which they are reported. Ids are never reused.
std::span<const GateRule> gate_rules();

// The rules as the table of schemas/gate_rules.md.
std::string rules_table();

bool is_within(double value, Bound bound, double allowed);

// "74.2 %" of a share, "41.2 m", "0.031 nat".
std::string in_words(double value, std::string_view unit);

std::string within(double limit_m);  // " within 0.1 m"

// What a rule found that is about the whole map alone, or why it cannot be judged.
std::vector<Found> of_whole_map(double value, std::string message);
std::vector<Found> not_judged(std::string why);

// The rules by what they need; gate_rules() joins them.
std::span<const GateRule> rules_of_map();
std::span<const GateRule> rules_of_observation();
std::span<const GateRule> rules_of_identity();
std::span<const GateRule> rules_of_change();

}  // namespace sightline
