#include <algorithm>
#include <cstdio>
#include <ctime>
#include <memory>
#include <optional>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/console/console.h"
#include "compiler/cli/console/written.h"
#include "compiler/commands/commands.h"
#include "compiler/commands/verdict_output.h"
#include "compiler/gate/forms/gate_text.h"
#include "compiler/gate/gate.h"
#include "formats/base/files/atomic_file.h"
#include "formats/foreign/text/text_lines.h"
#include "formats/map/map_reader.h"

namespace sightline {
namespace {

struct Form {
  const char* name;
  std::string (*write)(const GateReport&);
  const char* help;
};

constexpr Form kForms[] = {{"text", &to_text, "Also write the text to this file"},
                           {"json", &to_json, "Also write JSON (schemas/gate.schema.json)"},
                           {"junit", &to_junit, "Also write JUnit XML"},
                           {"sarif", &to_sarif, "Also write SARIF 2.1.0"},
                           {"github", &to_github, "Also write GitHub annotations"},
                           {"markdown", &to_markdown, "Also write Markdown"}};

struct GateFlags {
  std::string map;
  std::string old_map;
  std::string rules;
  std::string evaluation;
  std::string today;  // empty: by the clock
  std::vector<std::string> formats = {"text"};
  std::string output;  // empty: stdout
  bool prints_all = false;
  std::vector<std::string> files = std::vector<std::string>(std::size(kForms));  // empty: none
  bool is_forced = false;
};

struct LoadedMap {
  CompiledMap map;
  MapSummary summary;
};

Result<LoadedMap> load_map(const std::string& file) {
  SIGHTLINE_ASSIGN(MapSummary summary, verify_map(file));
  SIGHTLINE_ASSIGN(CompiledMap map, read_map(file));
  return LoadedMap{std::move(map), std::move(summary)};
}

std::string day_by_the_clock() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[16];
  std::strftime(text, sizeof text, "%Y-%m-%d", &utc);
  return text;
}

Result<GateReport> judge_files(const GateFlags& flags, const GateSettings& settings) {
  SIGHTLINE_ASSIGN(const LoadedMap map, load_map(flags.map));
  const GateMap subject{flags.map, map.map, map.summary};
  std::optional<LoadedMap> old_file;
  std::optional<GateMap> old_map;
  if (!flags.old_map.empty()) {
    SIGHTLINE_ASSIGN(old_file, load_map(flags.old_map));
    old_map.emplace(GateMap{flags.old_map, old_file->map, old_file->summary});
  }
  std::optional<Observation> observation;
  if (!flags.evaluation.empty()) {
    SIGHTLINE_ASSIGN(observation, read_observation(flags.evaluation));
  }
  SIGHTLINE_ASSIGN(const std::optional<EvaluationFigures> figures,
                   figures_in(flags.evaluation, map.map));
  return judge({subject, old_map ? &*old_map : nullptr, observation ? &*observation : nullptr,
                figures ? &*figures : nullptr},
               settings, flags.today.empty() ? day_by_the_clock() : flags.today);
}

bool is_among(const std::vector<std::string>& formats, const Form& form) {
  return std::ranges::find(formats, form.name) != formats.end();
}

// The verdict and the result of the gate have colours at a terminal.
void print_for_people(const GateFlags& flags, const GateReport& report) {
  const std::string text = flags.prints_all ? to_text(report) : to_summary(report);
  const std::string head = "\n" + gate_head(report);
  const std::size_t at = text.find(head);
  const Tone tone = report.passes() ? Tone::kGood : Tone::kBad;
  print_text(with_toned_verdict(report.verdict, text.substr(0, at + 1)) +
             toned(tone, gate_head(report)) + text.substr(at + head.size()));
}

void print_forms(const GateFlags& flags, const GateReport& report) {
  for (const Form& form : kForms) {
    if (!is_among(flags.formats, form)) continue;
    std::string_view(form.name) == "text" ? print_for_people(flags, report)
                                          : print_data(form.write(report));
  }
}

Result<void> write_form(const GateFlags& flags, const std::string& file, const std::string& text) {
  SIGHTLINE_TRY(write_file_atomically(file, text, if_exists(flags.is_forced)));
  print_written(file);
  return {};
}

Result<void> write_report(const GateFlags& flags, const GateReport& report) {
  if (flags.output.empty()) print_forms(flags, report);
  std::string joined;
  for (const Form& form : kForms) {
    if (is_among(flags.formats, form)) joined += form.write(report);
  }
  if (!flags.output.empty()) SIGHTLINE_TRY(write_form(flags, flags.output, joined));
  for (std::size_t i = 0; i < std::size(kForms); ++i) {
    if (flags.files[i].empty()) continue;
    SIGHTLINE_TRY(
        write_file_atomically(flags.files[i], kForms[i].write(report), if_exists(flags.is_forced)));
  }
  return {};
}

// That begins with "gate:"; 1 where none does.
std::size_t line_of_section(const std::string& file) {
  const Result<std::string> text = file.empty() ? std::string() : read_text_file(file);
  if (!text) return 1;
  LineReader lines(*text);
  for (std::string_view line; lines.next(line);) {
    if (line.starts_with("gate:")) return lines.number();
  }
  return 1;
}

Result<void> gate(const GateFlags& flags) {
  GateSettings settings = default_gate_settings();
  if (!flags.rules.empty()) {
    SIGHTLINE_ASSIGN(settings, read_gate_settings(flags.rules));
  }
  SIGHTLINE_ASSIGN(GateReport report, judge_files(flags, settings));
  report.rules_file = flags.rules;
  report.rules_line = line_of_section(flags.rules);
  SIGHTLINE_TRY(write_report(flags, report));
  if (report.passes()) return {};
  return Error{ErrorCode::kGateFailed,
               concat("found ", report.violations(Severity::kError), " errors and ",
                      report.violations(Severity::kWarning), " warnings; the gate fails at any ",
                      severity_name(settings.fails_at)),
               flags.map};
}

}  // namespace

Verb gate_verb() {
  const auto flags = std::make_shared<GateFlags>();
  std::vector<std::string> forms;
  for (const Form& form : kForms) forms.emplace_back(form.name);
  Verb verb;
  verb.name = "gate";
  verb.summary = "Judge a map by rules, alone and against the one before it";
  verb.details =
      "Prints the verdict on the map and the result of the rules. Exit status 0: the map passes, "
      "69: it does not. Rules, their thresholds and exceptions by "
      "place are described in schemas/gate_rules.md.";
  verb.examples = {
      "sightline gate town.slmap",
      "sightline gate town.slmap --against release.slmap --rules town.yaml --json gate.json",
      "sightline gate town.slmap --against release.slmap --format github --junit gate.xml \\\n"
      "      --sarif gate.sarif --markdown summary.md"};
  verb.positionals = {map_positional(flags->map, "The map to judge")};
  verb.flags = {
      {.names = "--against",
       .value = "FILE",
       .help = "An older map (.slmap): judge the change too",
       .target = &flags->old_map},
      {.names = "--rules",
       .value = "FILE",
       .help = "YAML with thresholds and exceptions, perhaps in a section 'gate'",
       .target = &flags->rules},
      {.names = "--evaluation",
       .value = "FILE",
       .help = "The JSON of `sightline evaluate` for this map: the verdict and rules of an "
               "observing drive use it",
       .target = &flags->evaluation},
      {.names = "--today",
       .value = "DATE",
       .help = "Day for the expiry of exceptions, such as 2026-12-01; default: today (UTC)",
       .target = &flags->today},
      {.names = "--format",
       .value = "FORMAT",
       .help = "Form of the output",
       .target = &flags->formats,
       .choices = forms},
      output_flag(flags->output, "Write the output to this file, not to stdout"),
      {.names = "--all",
       .help = "Print every check, not only what fits on 12 lines",
       .target = &flags->prints_all}};
  for (std::size_t i = 0; i < std::size(kForms); ++i) {
    verb.flags.push_back({.names = std::string("--") + kForms[i].name,
                          .value = "FILE",
                          .help = kForms[i].help,
                          .target = &flags->files[i]});
  }
  verb.flags.push_back(force_flag(flags->is_forced));
  verb.run = [flags] { return exit_status_of(gate(*flags)); };
  return verb;
}

}  // namespace sightline
