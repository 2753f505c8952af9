#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/views/verdict/answer_kind.h"
#include "compiler/views/verdict/drive_origin.h"
#include "formats/annotation/drive_tracks.h"
#include "formats/base/result.h"
#include "formats/evaluation/evaluation.h"
#include "formats/map/compiled_map.h"

// The figures of an evaluation that the verdict is about. They are the same whether they come from
// the artifacts of an evaluation or from the JSON that `sightline evaluate` wrote. Times differ
// from run to run and are for printing; all else is the same.

namespace sightline {

// How one kind of answer did at one limit. Shares are of the scans of the replayed drive; where the
// drive was not replayed, of the judged sites.
struct AnswerScore {
  AnswerKind kind = AnswerKind::kRange;
  double coverage = 0.0;  // error at most the limit
  // The same where the map has an answer that it calls good enough; 1 where it has none at all.
  double answered_coverage = 0.0;
  double time_ratio = 0.0;                  // to the longest range everywhere; of CPU times
  double work_ratio = 0.0;                  // of points times iterations
  std::optional<std::uint32_t> lost_count;  // tracks; none: the drive was not replayed
  friend bool operator==(const AnswerScore&, const AnswerScore&) = default;
};

// The same for one look or range that is taken everywhere.
struct ConstantScore {
  std::string look;
  double coverage = 0.0;
  double time_ratio = 0.0;
  double work_ratio = 0.0;
  std::optional<std::uint32_t> lost_count;
  friend bool operator==(const ConstantScore&, const ConstantScore&) = default;
};

struct LimitFigures {
  double limit_m = 0.0;
  std::vector<AnswerScore> answers;      // ascending by kind; those that were judged
  std::vector<ConstantScore> constants;  // in the evaluation's order
  friend bool operator==(const LimitFigures&, const LimitFigures&) = default;
};

struct EvaluationFigures {
  std::string drive;
  bool is_simulated = false;  // no drive was measured
  DriveOrigin origin = DriveOrigin::kOther;
  std::string map_id = {};         // of the map that was judged; empty: the file does not say
  std::string root_digest = {};    // of that map's file, hexadecimal; empty: the file does not say
  std::uint32_t site_count = 0;    // of the map
  std::uint32_t judged_count = 0;  // sites
  std::uint32_t scan_count = 0;    // replayed; 0: the drive was not replayed
  std::vector<LimitFigures> limits;
  friend bool operator==(const EvaluationFigures&, const EvaluationFigures&) = default;
};

// `evaluation` and `tracks` are of this map; `tracks`: null where the drive was not replayed. Does
// not know whether the drive is the map's own.
EvaluationFigures figures_of(const CompiledMap& map, const Evaluation& evaluation,
                             const DriveTracks* tracks);

// Of the JSON that `sightline evaluate --json` wrote. Errors: file-not-found, cannot-open,
// cannot-read; malformed-text (it is not that JSON); mismatched-inputs (it is of another map).
Result<EvaluationFigures> read_evaluation(const std::filesystem::path& file,
                                          const CompiledMap& map);
Result<EvaluationFigures> parse_evaluation(std::string_view json, const CompiledMap& map);

// The constant answer of least work that keeps at least as many within the limit and loses no more
// tracks than `answer`; where there is none, the one that keeps most (then loses fewest, then needs
// the least work). The first of equals. Null: none was judged.
const ConstantScore* best_constant(const LimitFigures& figures, const AnswerScore& answer);

// The constant answer that keeps most within the limit (then loses fewest tracks) of those that
// need at most `most_work_ratio`. Null: there is none.
const ConstantScore* best_constant_within(const LimitFigures& figures, double most_work_ratio);

}  // namespace sightline
