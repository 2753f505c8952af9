#include "compiler/cli/common_flags.h"

#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <memory>
#include <string_view>
#include <variant>

#include "compiler/cli/console/console.h"
#include "compiler/cli/file_kind.h"
#include "formats/base/thread_limit.h"

namespace sightline {
namespace {

// Files that cannot be made again.
bool is_made_by_hand(const std::filesystem::path& path) {
  const std::optional<FileKind> kind = kind_of_file(path);
  return kind == FileKind::kConfiguration ||
         (kind == FileKind::kRecording && holds_many_scans(path));
}

}  // namespace

Flag output_flag(std::string& file, const std::string& help) {
  return {.names = "-o,--output", .value = "FILE", .help = help, .target = &file};
}

Flag required_output_flag(std::string& file, const std::string& help) {
  Flag flag = output_flag(file, help);
  flag.is_required = true;
  return flag;
}

Flag ending_in(const std::string& ending, Flag output) {
  output.endings = {ending};
  return output;
}

Flag force_flag(bool& is_forced) {
  return {.names = "--force", .help = "Replace outputs that exist", .target = &is_forced};
}

IfExists if_exists(bool is_forced) { return is_forced ? IfExists::kReplace : IfExists::kRefuse; }

Flag quiet_flag(bool& is_quiet) {
  return {.names = "-q,--quiet",
          .help = "Print no progress and no summary: only requested data, warnings and errors",
          .target = &is_quiet};
}

Flag verbose_flag(bool& is_verbose) {
  return {.names = "-v,--verbose",
          .help = "Also log on stderr what was done and its time and memory",
          .target = &is_verbose,
          .excludes = "--quiet"};
}

void add_verbosity_flags(Verb& verb) {
  struct VerbosityFlags {
    bool is_quiet = false;
    bool is_verbose = false;
  };
  const auto lacks = [&](const std::string& name) {
    return std::ranges::find(verb.flags, name, &long_name) == verb.flags.end();
  };
  const auto flags = std::make_shared<VerbosityFlags>();
  if (lacks("--quiet")) verb.flags.push_back(quiet_flag(flags->is_quiet));
  if (lacks("--verbose")) verb.flags.push_back(verbose_flag(flags->is_verbose));
  verb.run = [flags, name = verb.name, run = std::move(verb.run)] {
    const auto begin = std::chrono::steady_clock::now();
    Result<int> status = run();
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
    if (flags->is_verbose) log_cost("sightline " + name, wall.count());
    return status;
  };
}

void add_thread_limit(Verb& verb) {
  const auto flag = std::ranges::find(verb.flags, "--threads", &long_name);
  if (flag == verb.flags.end()) return;
  int* const threads = std::get<int*>(flag->target);
  verb.run = [threads, run = std::move(verb.run)] {
    // Kept after the run: where a limit ends, TBB starts threads, which a system may refuse.
    static auto* const kept = new std::unique_ptr<ThreadLimit>();
    kept->reset();
    *kept = std::make_unique<ThreadLimit>(*threads);
    return run();
  };
}

Flag threads_flag(int& threads) {
  return {.names = "-j,--threads",
          .value = "N",
          .help = "Threads to use; 0: as many as the machine has",
          .target = &threads,
          .minimum = 0,
          .maximum = 1024};
}

Flag time_passes_flag(bool& time_passes) {
  return {.names = "--time-passes",
          .help = "Print time and peak memory of each pass on stderr",
          .target = &time_passes};
}

Flag json_progress_flag(int& descriptor) {
  return {.names = "--json-progress",
          .value = "N",
          .help =
              "Report progress as one JSON object a line: on stderr, where it replaces the text, "
              "or on file descriptor N",
          .target = &descriptor,
          .minimum = 1,
          .bare_value = "2"};
}

Flag world_flag(std::string& world) {
  return {.names = "--world",
          .value = "WORLD",
          .help =
              "Coordinate frame of the recordings, if neither the map nor annotation.world in the "
              "configuration names it: local, utm:ZONE (utm:32N), mgrs:SQUARE (mgrs:32UMV) or "
              "enu:LATITUDE,LONGITUDE,ALTITUDE",
          .target = &world};
}

Flag expires_flag(std::string& time) {
  return {.names = "--expires",
          .value = "TIME",
          .help = "UTC time such as 2026-12-01T00:00:00Z, or days from now such as +7d",
          .target = &time};
}

Flag passphrase_flag(std::string& file) {
  return {.names = "--passphrase-file",
          .value = "FILE",
          .help = "The passphrase of the secret key is the first line of this file; - is stdin",
          .target = &file};
}

Positional map_positional(std::string& file, const std::string& help) {
  return {.name = "MAP", .help = help + " (.slmap)", .target = &file};
}

Result<void> try_output(const std::filesystem::path& path, IfExists if_exists) {
  if (path.empty()) return {};
  if (!path.has_filename()) {
    return Error{ErrorCode::kBadArgument, "this names a folder; name the file in it",
                 path.string()};
  }
  SIGHTLINE_TRY(check_output(path, if_exists));
  if (is_made_by_hand(path)) {
    return Error{ErrorCode::kCannotWrite,
                 "this is a configuration or a recording, which is never replaced, not even with "
                 "--force; name another file",
                 path.string()};
  }
  std::error_code failure;
  std::filesystem::path folder = std::filesystem::absolute(path, failure).parent_path();
  while (folder.has_relative_path() && !std::filesystem::exists(folder, failure)) {
    folder = folder.parent_path();
  }
  if (!std::filesystem::is_directory(folder, failure)) {
    return write_failure(path, folder.string() + " is a file, and a folder is needed", ENOTDIR);
  }
  if (::access(folder.c_str(), W_OK | X_OK) != 0) {
    return write_failure(path, "no file can be written in " + folder.string(), errno);
  }
  const long longest = ::pathconf(folder.c_str(), _PC_NAME_MAX);
  if (longest > 0 && path.filename().native().size() > static_cast<std::size_t>(longest)) {
    return write_failure(path, "the output cannot have this name", ENAMETOOLONG);
  }
  return {};
}

}  // namespace sightline
