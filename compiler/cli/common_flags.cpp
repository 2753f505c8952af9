#include "compiler/cli/common_flags.h"

namespace sightline {

Flag output_flag(std::string& file, const std::string& help) {
  return {.names = "-o,--output", .value = "FILE", .help = help, .target = &file};
}

Flag required_output_flag(std::string& file, const std::string& help) {
  Flag flag = output_flag(file, help);
  flag.is_required = true;
  return flag;
}

Flag force_flag(bool& is_forced) {
  return {.names = "--force", .help = "Replace outputs that exist", .target = &is_forced};
}

Flag quiet_flag(bool& is_quiet) {
  return {.names = "-q,--quiet",
          .help = "Print only warnings and errors, on stderr",
          .target = &is_quiet};
}

Flag threads_flag(int& threads) {
  return {.names = "--threads",
          .value = "N",
          .help = "Threads to use; 0 takes all there are",
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
              "Report progress as one JSON object a line, on stderr instead of the lines for "
              "people, or on file descriptor N",
          .target = &descriptor,
          .minimum = 1,
          .bare_value = "2"};
}

Flag world_flag(std::string& world) {
  return {.names = "--world",
          .value = "WORLD",
          .help =
              "Where the recordings' coordinates lie, where neither map nor configuration "
              "(annotation.world) says: local, utm:ZONE (utm:32N), mgrs:SQUARE (mgrs:32UMV) or "
              "enu:LATITUDE,LONGITUDE,ALTITUDE",
          .target = &world};
}

Flag expires_flag(std::string& time) {
  return {.names = "--expires",
          .value = "TIME",
          .help = "UTC as 2026-12-01T00:00:00Z, or days from now as +7d",
          .target = &time};
}

Flag passphrase_flag(std::string& file) {
  return {.names = "--passphrase-file",
          .value = "FILE",
          .help = "The secret key's passphrase: the first line of this file; - is stdin",
          .target = &file};
}

Positional map_positional(std::string& file, const std::string& help) {
  return {.name = "MAP", .help = help + " (.slmap)", .target = &file};
}

}  // namespace sightline
