#include <cstdio>
#include <memory>

#include "compiler/base/atomic_file.h"
#include "compiler/driver/commands.h"
#include "compiler/driver/console.h"
#include "compiler/driver/init/draft_config.h"

namespace sightline {
namespace {

struct InitFlags {
  std::string folder;
  std::string output;  // empty: stdout
  bool is_forced = false;
};

Result<void> run_init(const InitFlags& flags) {
  const Result<ConfigDraft> draft = draft_config(flags.folder, flags.output);
  if (!draft) return draft.error();
  for (const std::string& line : draft->summary) std::fprintf(stderr, "%s\n", line.c_str());
  if (flags.output.empty()) {
    std::fputs(draft->yaml.c_str(), stdout);
    return {};
  }
  return write_file_atomically(flags.output, draft->yaml,
                               flags.is_forced ? IfExists::kReplace : IfExists::kRefuse);
}

}  // namespace

void add_init_command(CLI::App& app, int& status) {
  const auto flags = std::make_shared<InitFlags>();
  CLI::App* command = app.add_subcommand(
      "init", "Look at a folder of recordings and write a configuration that compiles");
  command->footer(
      "Finds folders of scans, ROS bags and pcaps up to four folders deep, poses and times beside\n"
      "them, tells the sensor by its beams and whether the poses fit the scans. A comment above each\n"
      "key says what it was guessed from.\n\n"
      "Examples:\n"
      "  sightline init recordings/ -o drive.yaml\n"
      "  sightline init recordings/ > drive.yaml\n"
      "  sightline compile drive.yaml -o drive.slmap");
  command->add_option("folder", flags->folder, "The folder of recordings, or one bag or pcap")
      ->required();
  command->add_option("-o,--output", flags->output,
                      "The configuration to write (.yaml); default: print it");
  command->add_flag("--force", flags->is_forced, "Replace the output if it exists");
  command->callback([flags, &status] {
    const Result<void> done = run_init(*flags);
    status = done ? 0 : report_error(done.error());
  });
}

}  // namespace sightline
