#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compiler/views/verdict/drive_origin.h"
#include "compiler/views/verdict/evaluation_figures.h"

namespace sightline {

enum class MapVerdict : std::uint8_t { kGood, kPartly, kBad, kNotJudged };

// The thresholds of the verdict.
struct VerdictThresholds {
  // Share of scans or sites within the limit, where the map does not name the share that may miss.
  static constexpr double kTarget = 0.95;
  // Bad: more than so many times the misses that the target allows. In between: partly.
  static constexpr double kBadMisses = 2.0;
  // Partly: an answer that is good enough at fewer places, or none along so much route.
  static constexpr double kLeastAnswered = 0.99;
  static constexpr double kUnmetStretch_m = 10.0;
  // Partly: the recommended answer needs more than so many times the work of the best fixed choice
  // that has at least its share within the limit and loses no more tracks. By work, since times
  // differ from run to run.
  static constexpr double kMoreWork = 1.05;
  // Partly: the drive judged fewer of the map's places.
  static constexpr double kLeastJudged = 0.5;
  // Partly: a stretch of the way of such a length whose poses rest on an assumed speed, since scans
  // do not constrain them.
  static constexpr double kAssumed_m = 20.0;
};

// What the verdict rests on.
enum class Evidence : std::uint8_t {
  kNone,       // no drive: errors were simulated, or none was measured
  kOwnDrive,   // the localization drive, from which the map's model learned
  kEvaluation  // an evaluation file
};

// One limit of the map.
struct LimitVerdict {
  double limit_m = 0.0;
  MapVerdict verdict = MapVerdict::kNotJudged;
  // The first of plan, look and range that reaches the target and needs no more work than a fixed
  // choice; where there is none, the first that reaches it; where none does, the first.
  AnswerKind recommended = AnswerKind::kRange;
  double target = VerdictThresholds::kTarget;  // share within the limit
  // Of the places: there a look or a range is good enough; there the recommended answer is.
  double answered_share = 0.0;
  double recommended_share = 0.0;
  double expected_coverage = 0;  // that the map predicts for the recommended answer
  double unmet_m = 0.0;          // the longest stretch of route without a good enough answer
  std::size_t unmet_site = 0;    // where it begins
  bool has_looks = false;        // the map has looks beside ranges
  // Of the recommended answer; of the looks where a plan was not judged. None: not judged.
  std::optional<AnswerScore> score;
  std::optional<ConstantScore> constant;   // best_constant() beside it
  std::optional<ConstantScore> same_work;  // the best constant answer of at most its work
  std::string reason;                      // why it is not good; empty: it is, or is not judged
};

struct MapJudgement {
  MapVerdict verdict = MapVerdict::kNotJudged;  // the worst of the limits
  Evidence evidence = Evidence::kNone;
  std::string drive;                         // that judged
  DriveOrigin origin = DriveOrigin::kOther;  // of that drive
  bool is_own_drive = false;                 // the map or its model was made from it: optimistic
  bool has_other_scans = false;    // a half of the scans of its drive did not make the map
  std::uint32_t judged_count = 0;  // scans where the drive was replayed, else places
  bool is_replayed = false;
  std::vector<LimitVerdict> limits;  // as in the map
  std::size_t deciding = 0;          // the first of the limits that has the verdict
  std::string reason;                // of that limit or of the map; empty: none
  std::string figures;               // one sentence
  std::string promise;               // one sentence of the map, for the recommended answer
  std::string next;                  // a command, and after "  # " what it does
};

// What names of files the next command contains.
struct VerdictFiles {
  std::string map = "MAP";
  std::string config = "CONFIG";
  bool names_evaluation = true;  // the configuration names a drive under `evaluation`
};

}  // namespace sightline
