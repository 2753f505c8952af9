#pragma once

#include <optional>
#include <string>
#include <vector>

#include "compiler/views/verdict/map_judgement.h"
#include "formats/drive/unconstrained_stretches.h"

// The sentences of a verdict. Places are those of the map, scans those of the evaluated drive.

namespace sightline {

// Why an answer misses the target of `verdict`. `constant`: the best fixed choice beside it.
std::string why_missed(const AnswerScore& score, const std::optional<ConstantScore>& constant,
                       const LimitVerdict& verdict);
// "its looks reach the target"
std::string reaching(AnswerKind kind);
// Of a score that needs more work than the fixed choice, both of which `verdict` has.
std::string why_more_work(const LimitVerdict& verdict);
std::string why_unanswered(const LimitVerdict& verdict);

// Of one stretch or more, whose poses rest on an assumed speed.
std::string why_assumed(const std::vector<UnconstrainedStretch>& stretches);

// What was measured at the limit, or is predicted, without its end.
std::string figures_sentence(const MapJudgement& judgement, const LimitVerdict& limit);

// With a capital letter and a full stop; an empty text stays empty.
std::string as_sentence(std::string text);

// A command that lists what `inspect` has of poses.
std::string listing_command(const VerdictFiles& files, const std::string& what_it_does);
// A command that works with these files, and after "  # " what it does.
std::string next_command(const MapJudgement& judgement, const VerdictFiles& files);

}  // namespace sightline
