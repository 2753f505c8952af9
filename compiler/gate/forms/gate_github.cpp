#include <array>

#include "compiler/gate/forms/gate_text.h"

namespace sightline {
namespace {

// What a workflow command would take for its own syntax, as %XX.
std::string escaped(const std::string& text, std::string_view reserved) {
  static constexpr const char* kDigits = "0123456789ABCDEF";
  std::string safe;
  for (const char c : text) {
    if (reserved.find(c) == std::string_view::npos) {
      safe += c;
      continue;
    }
    const auto byte = static_cast<unsigned char>(c);
    safe += {'%', kDigits[byte / 16], kDigits[byte % 16]};
  }
  return safe;
}

std::string in_message(const std::string& text) { return escaped(text, "%\r\n"); }
std::string in_property(const std::string& text) { return escaped(text, "%\r\n:,"); }

}  // namespace

std::string to_github(const GateReport& report) {
  static constexpr std::array<const char*, 3> kCommands = {"notice", "warning", "error"};
  std::string text;
  for (const Check& check : report.checks) {
    if (check.verdict != Verdict::kViolated) continue;
    const bool is_of_old = check.place && check.place->is_of_old && report.old_map;
    text += std::string("::") + kCommands[static_cast<std::size_t>(check.severity)] +
            " file=" + in_property(is_of_old ? report.old_map->file : report.map.file) +
            ",title=" + in_property(check.rule) + "::" + in_message(check.message) + "\n";
  }
  const char* verdict = report.passes() ? "::notice title=sightline gate::passed"
                                        : "::error title=sightline gate::failed";
  return text + verdict + ", " + std::to_string(report.violations(Severity::kError)) +
         " errors and " + std::to_string(report.violations(Severity::kWarning)) + " warnings\n";
}

}  // namespace sightline
