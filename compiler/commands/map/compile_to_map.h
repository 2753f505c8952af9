#pragma once

#include <string>
#include <vector>

#include "compiler/cli/run_flags.h"
#include "compiler/config/compile_config.h"
#include "compiler/driver/plans.h"
#include "compiler/pipeline/runner.h"
#include "compiler/views/verdict/verdict.h"
#include "formats/base/files/atomic_file.h"
#include "formats/base/result.h"

// What verbs that make a map share: compile, annotate and link.

namespace sightline {

// What is printed of a map that was written.
struct SummaryFlags {
  std::string format = "text";  // or json, as `inspect` prints it
  bool prints_tables = false;   // of the evaluation, behind the summary
};

struct CompileFlags {
  RunFlags run;
  std::string output;
  std::string model;    // empty: by annotation.model
  std::string depfile;  // empty: none
  std::string poses;    // of one drive, for the next map; empty: none
  bool lists_inputs = false;
  bool is_dry = false;  // estimates what it would take
  bool is_forced = false;
  SummaryFlags summary;
};

// -o, --force, --model, --risk, --strict, --list-inputs, --dry-run,
// --depfile, --format, --tables.
void add_compile_flags(Verb& verb, CompileFlags& flags);

// Makes the map of a configuration, writes it with its provenance and prints what it found.
Result<void> compile_to_map(const CompileFlags& flags, const CompileConfig& config);

// Writes the map that was made, and beside it its provenance and, of several drives, their poses
// for the next map (.slposes).
Result<void> write_compiled(const std::string& output, IfExists if_exists,
                            const CompileConfig& config, const CompilePlan& compile,
                            const ArtifactSet& artifacts, const std::vector<StepReport>& reports);
// Whether the map and its provenance could be written there; before hours of work.
Result<void> try_outputs_of_map(const std::string& output, IfExists if_exists);
// Whether the poses could.
Result<void> try_poses_output(const std::string& output, IfExists if_exists,
                              const CompilePlan& compile);
// Of a map that was written: its path, size and extent, the verdict, the promise, the next command.
// `files`: the map and, for the next command, its configuration. The reported_artifacts() are in
// `artifacts`. Errors: those of reading the map and the artifacts.
Result<void> print_summary(const SummaryFlags& flags, const VerdictFiles& files,
                           const CompilePlan& compile, const ArtifactSet& artifacts);
// --format and --tables.
void add_summary_flags(Verb& verb, SummaryFlags& flags);

}  // namespace sightline
