#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/cli/console/remaining_time.h"
#include "compiler/pipeline/runner.h"
#include "formats/base/error.h"
#include "formats/base/result.h"

// What people see while a command runs: only data is written to stdout; log, warnings
// and progress go to stderr.

namespace sightline {

enum class Verbosity {
  kQuiet,   // warnings
  kNormal,  // and one line for each finished step
  kVerbose  // and when each step starts, why it ran, and what it cost
};

// Of the command that runs; normal until it is set.
void set_verbosity(Verbosity verbosity);
Verbosity verbosity();

// What a text means, by which it is coloured: green, red, yellow, bold, grey.
enum class Tone { kGood, kBad, kWarning, kStrong, kFaint };

// The text in the colour of its tone, printable (printable()), for print_text(). As it is where
// stdout is no terminal or NO_COLOR is set and not empty.
std::string toned(Tone tone, std::string_view text);

// One line of information on stderr, unless quiet.
void print_note(const std::string& line);

// "warning ..." on stderr, also where quiet: something that the user should act on.
void print_warning(const std::string& text);

// "info sightline gate took 0.8 s and 210 MiB of memory" on stderr; the memory is the most so far.
void log_cost(const std::string& command, double wall_s);

// Reports a run on stderr; unless quiet, with the share done and the time that remains; of the
// whole run too where `expected` has what each of its steps is expected to take: on
// a terminal in a moving line, else (and where TERM is unknown or dumb) in a line every so many
// seconds. `printed` tables go to stdout as CSV.
RunObserver console_observer(Verbosity verbosity, std::vector<ExpectedTime> expected = {},
                             double line_every_s = 30.0);

// On stdout, with what could steer a terminal escaped (log_text()), except the colours of toned():
// for words out of files.
void print_text(std::string_view text);
// On stdout as it is, unless that is a terminal: then as print_text().
void print_data(std::string_view data);

// "SL2006 truncated-scan: ..." on stderr; returns the exit status that belongs to it.
int report_error(const Error& error);

// A table of pass times and memory, for --time-passes.
std::string time_table(const std::vector<StepReport>& reports);

// Why each step ran or did not, for --explain.
std::string explanation(const std::vector<StepReport>& reports);

// From here on Ctrl-C prints whether finished passes are kept, and the process dies of the signal;
// unfinished files are removed by the next run. A signal that was ignored at the start stays so.
void explain_interruption(bool has_cache);

// Reports a run on a file descriptor as one JSON object a line, for programs that show progress:
//   {"event":"started","pass":"build-ndt","step":6,"steps":21}
//   {"event":"progress","pass":"build-ndt","step":6,"steps":21,"done":80,"total":301,
//    "elapsed_s":0.412,"remaining_s":1.138,"run_remaining_s":31.4}
//   {"event":"warning","pass":"build-ndt","message":"..."}
//   {"event":"finished","pass":"build-ndt","step":6,"steps":21,"wall_s":1.52,"cpu_s":2.9,
//    "peak_memory_mib":211.0,"from_cache":false}
// Steps count from 1; "remaining_s" is of the pass, absent before anything is done, and
// "run_remaining_s" of the whole run, where `expected` has what each of its steps is expected to
// take. Progress comes at most five times a second, the last of a pass always. Lines
// are written whole. A reader that has gone away ends the reports, not the run.
RunObserver json_observer(int descriptor, std::vector<ExpectedTime> expected = {});

// Error: bad-argument where the descriptor is not open for writing.
Result<void> check_progress_descriptor(int descriptor);

RunObserver both(RunObserver first, RunObserver second);

}  // namespace sightline
