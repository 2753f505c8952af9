#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "compiler/pipeline/plan.h"
#include "formats/base/hash.h"

namespace sightline {

// What decides a step's output, and the name that it gives it.
struct StepKey {
  std::string record;  // lines "name = value" that a person can compare
  Digest key{};        // of the step's name and the record
};

// `key_of_input`: of an artifact of the plan.
StepKey step_key(const Plan& plan, const PassStep& step, std::uint64_t seed,
                 const std::function<Digest(std::size_t artifact)>& key_of_input);

// Why a step must run: the first lines in which its record differs from that of the last run.
std::string reason_to_run(const std::string& before, const std::string& now);

}  // namespace sightline
