#include <filesystem>
#include <memory>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/console/console.h"
#include "compiler/cli/console/written.h"
#include "compiler/commands/commands.h"
#include "compiler/config/config_file.h"
#include "compiler/driver/configuration.h"
#include "compiler/init/draft_config.h"
#include "formats/base/files/atomic_file.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

struct InitFlags {
  std::string folder;
  std::string output;  // empty: stdout
  std::string sensor;
  bool has_no_schema = false;
  bool is_forced = false;
};

constexpr const char* kSchemaName = "sightline.schema.json";

// Beside the configuration; empty: none is written.
fs::path schema_file(const InitFlags& flags) {
  std::error_code failure;
  const bool is_device =
      fs::exists(flags.output, failure) && !fs::is_regular_file(flags.output, failure);
  if (flags.output.empty() || flags.has_no_schema || is_device) return {};
  return fs::path(flags.output).parent_path() / kSchemaName;
}

// Of this program: that of another version is replaced, a file that is no schema of ours is not.
Result<void> write_schema(const fs::path& file, bool is_forced) {
  CompileConfig config;
  const std::string text = to_json_schema(published_sections(config));
  std::error_code failure;
  IfExists if_there = if_exists(is_forced);
  if (fs::exists(file, failure)) {
    SIGHTLINE_ASSIGN(const std::string before, read_text_file(file));
    if (before == text) return {};
    if (before.find("\"title\": \"sightline configuration\"") != std::string::npos) {
      if_there = IfExists::kReplace;
    }
  }
  return write_file_atomically(file, text, if_there);
}

Result<void> run_init(const InitFlags& flags) {
  SIGHTLINE_TRY(check_output(flags.output, if_exists(flags.is_forced)));
  const fs::path schema = schema_file(flags);
  SIGHTLINE_ASSIGN(
      const ConfigDraft draft,
      draft_config(flags.folder, flags.output, {flags.sensor, schema.filename().string()}));
  for (const std::string& line : draft.summary) print_note(line);
  if (flags.output.empty()) {
    print_text(draft.yaml);
    return {};
  }
  if (!schema.empty()) SIGHTLINE_TRY(write_schema(schema, flags.is_forced));
  SIGHTLINE_TRY(write_file_atomically(flags.output, draft.yaml, if_exists(flags.is_forced)));
  print_written(flags.output, "a configuration; comments give the reasons for its values");
  if (!schema.empty()) print_written(schema, "completion and checks in editors");
  if (verbosity() == Verbosity::kQuiet) return {};
  print_text(concat("Next: sightline compile ", flags.output, " -o ",
                    fs::path(flags.output).replace_extension(".slmap").string(),
                    "\n      --dry-run estimates the time first\n"));
  return {};
}

}  // namespace

Verb init_verb() {
  const auto flags = std::make_shared<InitFlags>();
  Verb verb;
  verb.name = "init";
  verb.summary = "Examine a folder of recordings and write a configuration";
  verb.details =
      "Finds folders of scans, ROS 1 and ROS 2 bags and pcaps up to four folders deep, with poses "
      "and times beside them. Recognizes the sensor by its beams and checks whether the poses fit "
      "the scans. A comment above each key gives the reason for its value.\n\n"
      "With -o, sightline.schema.json is written beside the configuration, whose first line names "
      "it: editors with the YAML language server then complete and check keys.";
  verb.examples = {"sightline init recordings/ -o drive.yaml",
                   "sightline init recordings/ -o drive.yaml --sensor xt16",
                   "sightline init recordings/ > drive.yaml",
                   "sightline compile drive.yaml -o drive.slmap"};
  verb.positionals = {{.name = "FOLDER",
                       .help = "A folder of recordings, or one bag or pcap",
                       .target = &flags->folder}};
  verb.flags = {output_flag(flags->output, "The configuration to write (.yaml); default: stdout"),
                force_flag(flags->is_forced),
                {.names = "--sensor",
                 .value = "NAME",
                 .help = "Sensor of the recordings: a profile (`sensor` in a configuration) or a "
                         "file with its beams; default: recognized",
                 .target = &flags->sensor},
                {.names = "--no-schema",
                 .help = "Do not write sightline.schema.json",
                 .target = &flags->has_no_schema}};
  verb.run = [flags] { return exit_status_of(run_init(*flags)); };
  return verb;
}

}  // namespace sightline
