#include <cstdio>
#include <memory>

#include "compiler/cli/common_flags.h"
#include "compiler/cli/console/console.h"
#include "compiler/commands/commands.h"
#include "compiler/init/draft_config.h"
#include "formats/base/files/atomic_file.h"

namespace sightline {
namespace {

struct InitFlags {
  std::string folder;
  std::string output;  // empty: stdout
  bool is_forced = false;
};

Result<void> run_init(const InitFlags& flags) {
  SIGHTLINE_ASSIGN(const ConfigDraft draft, draft_config(flags.folder, flags.output));
  for (const std::string& line : draft.summary) std::fprintf(stderr, "%s\n", line.c_str());
  if (flags.output.empty()) {
    print_text(draft.yaml);
    return {};
  }
  return write_file_atomically(flags.output, draft.yaml, if_exists(flags.is_forced));
}

}  // namespace

Verb init_verb() {
  const auto flags = std::make_shared<InitFlags>();
  Verb verb;
  verb.name = "init";
  verb.summary = "Look at a folder of recordings and write a configuration that compiles";
  verb.details =
      "Finds folders of scans, bags of ROS 1 and ROS 2 and pcaps up to four folders deep, poses "
      "and times beside them, recognizes the sensor by its beams and checks whether the poses fit "
      "the scans. A comment above each key names its source.";
  verb.examples = {"sightline init recordings/ -o drive.yaml",
                   "sightline init recordings/ > drive.yaml",
                   "sightline compile drive.yaml -o drive.slmap"};
  verb.positionals = {{.name = "FOLDER",
                       .help = "The folder of recordings, or one bag or pcap",
                       .target = &flags->folder}};
  verb.flags = {output_flag(flags->output, "The configuration to write (.yaml), not stdout"),
                force_flag(flags->is_forced)};
  verb.run = [flags] { return exit_status_of(run_init(*flags)); };
  return verb;
}

}  // namespace sightline
