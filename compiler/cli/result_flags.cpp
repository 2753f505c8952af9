#include "compiler/cli/result_flags.h"

#include <algorithm>
#include <filesystem>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/console/console.h"
#include "compiler/cli/console/written.h"
#include "formats/base/files/atomic_file.h"
#include "formats/base/printable.h"

namespace sightline {

std::string ResultFlags::chosen_format(const std::vector<std::string>& formats) const {
  const std::string ending = std::filesystem::path(output).extension().string();
  if (format != "text" || ending.size() < 2) return format;
  const bool is_known = std::ranges::find(formats, ending.substr(1)) != formats.end();
  return is_known ? ending.substr(1) : format;
}

void add_result_flags(Verb& verb, ResultFlags& flags, const std::vector<std::string>& formats,
                      const std::string& json_help) {
  verb.flags.push_back({.names = "--format",
                        .value = "FORMAT",
                        .help = "Form of the result; " + json_help,
                        .target = &flags.format,
                        .choices = formats});
  verb.flags.push_back(output_flag(flags.output, "Write the result to this file, not to stdout"));
  verb.flags.push_back(force_flag(flags.is_forced));
}

Result<void> try_result(const ResultFlags& flags) {
  return try_output(flags.output, if_exists(flags.is_forced));
}

Result<void> put_result(const ResultFlags& flags, const std::string& result) {
  if (flags.output.empty()) {
    flags.format == "text" ? print_text(result) : print_data(result);
    return {};
  }
  const std::string text = flags.format == "text" ? log_text(result) : result;
  SIGHTLINE_TRY(write_file_atomically(flags.output, text, if_exists(flags.is_forced)));
  print_written(flags.output);
  return {};
}

}  // namespace sightline
