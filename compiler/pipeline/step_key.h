#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "compiler/pipeline/plan.h"
#include "formats/base/hash.h"
#include "passes/pass/pass_context.h"

namespace sightline {

// What decides a step's output, and the name that it gives it. The label of a step, "mapping[2]" of
// "ingest:mapping[2]", decides nothing: a recording that another one was added before keeps its
// keys.
struct StepKey {
  std::string record;  // lines "name = value" that a person can compare
  Digest key{};        // of `way` and of the contents of the inputs, in their order
  Digest way{};        // of the pass and of the record without the inputs: how the step works
};

// `key_of_input`: of an artifact of the plan.
StepKey step_key(const Plan& plan, const PassStep& step, std::uint64_t seed,
                 const std::function<Digest(std::size_t artifact)>& key_of_input);

// Of a part of a step's work: with the content that it names, whatever inputs the step has.
Digest part_key(const StepKey& step, const PartName& part);

// Why a step must run: the first lines in which its record differs from that of the last run.
std::string reason_to_run(const std::string& before, const std::string& now);

}  // namespace sightline
