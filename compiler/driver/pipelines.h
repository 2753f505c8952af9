#pragma once

#include <vector>

#include "compiler/driver/plans.h"

// The passes of a compile, in their order.

namespace sightline {

CompilePlan compile_plan(const CompileConfig& config, ModelSource model = ModelSource::kTrained);

// The map, and what a compile reports of it.
std::vector<AnyWire> reported_artifacts(const CompilePlan& compile);

// Adds the steps that measure the evaluation drive on the map of the plan.
Wire<ByFamily<MeasuredError>> measure_evaluation_drive(const CompileConfig& config,
                                                       CompilePlan& compile);

}  // namespace sightline
