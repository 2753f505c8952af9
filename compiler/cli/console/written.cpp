#include "compiler/cli/console/written.h"

#include <fmt/format.h>
#include <system_error>

#include "compiler/cli/console/console.h"
#include "formats/base/printable.h"

namespace sightline {

std::string size_text(std::uint64_t bytes) {
  const double size = static_cast<double>(bytes);
  if (bytes < 1000) return fmt::format("{} bytes", bytes);
  if (size < 1e6) return fmt::format("{:.1f} kB", size / 1e3);
  if (size < 1e9) return fmt::format("{:.2f} MB", size / 1e6);
  return fmt::format("{:.2f} GB", size / 1e9);
}

std::string written_line(const std::filesystem::path& file, const std::string& about) {
  std::error_code failure;
  if (!std::filesystem::is_regular_file(file, failure)) return "";
  const std::uintmax_t size = std::filesystem::file_size(file, failure);
  if (failure) return "";
  const std::string line = fmt::format("Wrote {} ({})", one_line(file.string()), size_text(size));
  return about.empty() ? line + "\n" : fmt::format("{}: {}\n", line, about);
}

void print_written(const std::filesystem::path& file, const std::string& about) {
  if (verbosity() != Verbosity::kQuiet) print_text(written_line(file, about));
}

}  // namespace sightline
