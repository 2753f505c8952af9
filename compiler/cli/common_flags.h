#pragma once

#include <filesystem>
#include <string>

#include "compiler/cli/verb.h"
#include "formats/base/files/atomic_file.h"

// Flags of several verbs. They are made here so that each has one meaning.

namespace sightline {

// `help` names the file and its ending.
Flag output_flag(std::string& file, const std::string& help);
Flag required_output_flag(std::string& file, const std::string& help);
// The same flag for a file that ends so: ".slmap".
Flag ending_in(const std::string& ending, Flag output);

Flag force_flag(bool& is_forced);
IfExists if_exists(bool is_forced);
Flag quiet_flag(bool& is_quiet);
// Excludes quiet_flag(), which the verb must have too.
Flag verbose_flag(bool& is_verbose);
// What a verb lacks of -q and -v; both set the verbosity of the console, and a -v that is added
// here logs what the verb took.
void add_verbosity_flags(Verb& verb);
// The verb runs on the threads of its flag --threads; without the flag, on usable_threads().
void add_thread_limit(Verb& verb);
Flag threads_flag(int& threads);
Flag time_passes_flag(bool& time_passes);
Flag json_progress_flag(int& descriptor);
Flag world_flag(std::string& world);
Flag expires_flag(std::string& time);
Flag passphrase_flag(std::string& file);

Positional map_positional(std::string& file, const std::string& help);

// Whether a file may be written there, checked before hours of work and not after them: as
// check_output(), and whether its folder, or the deepest one on the way to it that exists, is one
// and lets files be made. A configuration or a recording (a bag, a capture) is never replaced. An
// empty path is fine: nothing is written. Errors: those of check_output(); cannot-write.
Result<void> try_output(const std::filesystem::path& path, IfExists if_exists);

}  // namespace sightline
