#pragma once

#include <string>

#include "compiler/cli/run_flags.h"
#include "compiler/config/compile_config.h"
#include "formats/base/result.h"

// What verbs that make a map share: compile and annotate.

namespace sightline {

struct CompileFlags {
  RunFlags run;
  std::string output;
  std::string model;    // empty: trained on this compile's own drive
  std::string depfile;  // empty: none
  bool lists_inputs = false;
  bool is_dry = false;  // tells what it would take
  bool is_forced = false;
};

// The flags of both: -o, --force, --model, --risk, --strict, --list-inputs, --dry-run, --depfile.
void add_compile_flags(Verb& verb, CompileFlags& flags);

// Makes the map of a configuration, writes it with its provenance and prints what it found.
Result<void> compile_to_map(const CompileFlags& flags, const CompileConfig& config);

}  // namespace sightline
