#pragma once

#include <string>
#include <vector>

#include "compiler/cli/verb.h"

namespace sightline {

Verb init_verb();
Verb compile_verb();
Verb annotate_verb();
Verb train_verb();
Verb plan_verb();
Verb work_verb();
Verb link_verb();
Verb status_verb();
Verb evaluate_verb();
Verb localize_verb();
Verb tune_verb();
Verb inspect_verb();
Verb dump_verb();
Verb export_verb();
Verb report_verb();
Verb verify_verb();
Verb diff_verb();
Verb gate_verb();
Verb weak_verb();
Verb delta_verb();
Verb apply_verb();
Verb strip_verb();
Verb recover_verb();
Verb key_verb();
Verb root_verb();
Verb release_verb();
Verb sign_verb();
Verb admit_verb();
Verb cache_verb();
Verb passes_verb();
Verb completion_verb();
Verb man_verb();
Verb help_verb();

// The whole command line, made again at each call, so that two parses share no values.
Program sightline_program();

// The lines of --version after the first: commit; versions of the formats that are written, that of
// the configuration as the beginning of its schema's SHA-256; kernels of the matcher that this
// processor supports, the one in use first; libraries of the build. None of it enters a map.
std::string build_details();

}  // namespace sightline
