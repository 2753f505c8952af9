#include <cstdio>
#include <memory>

#include "compiler/driver/commands.h"
#include "compiler/driver/console.h"
#include "formats/map/apply_delta.h"

namespace sightline {
namespace {

struct ApplyFlags {
  std::string delta;
  std::string map;
  std::string out;
  bool rolls_back = false;
};

Result<void> apply(const ApplyFlags& flags) {
  if (flags.rolls_back) {
    if (!flags.delta.empty() || !flags.out.empty()) {
      return Error{ErrorCode::kBadArgument, "--rollback takes no delta and no --out", "", ""};
    }
    const Result<Digest> root = roll_back(flags.map);
    if (!root) return root.error();
    std::printf("%s is map %s again\n", flags.map.c_str(), to_hex(*root).c_str());
    return {};
  }
  if (flags.delta.empty()) {
    return Error{ErrorCode::kBadArgument, "a delta is needed, or --rollback", "", ""};
  }
  const Result<ApplyReport> report =
      flags.out.empty() ? apply_delta(flags.delta, flags.map)
                        : apply_delta_to(flags.delta, flags.map, flags.out);
  if (!report) return report.error();
  std::printf("%s %s map %s\n", (flags.out.empty() ? flags.map : flags.out).c_str(),
              report->was_there ? "was already" : "is now", to_hex(report->root_digest).c_str());
  if (report->kept_bytes > 0) {
    std::fprintf(stderr, "%llu of %llu bytes were there from an apply that had been interrupted\n",
                 static_cast<unsigned long long>(report->kept_bytes),
                 static_cast<unsigned long long>(report->result_size));
  }
  return {};
}

}  // namespace

void add_apply_command(CLI::App& app, int& status) {
  const auto flags = std::make_shared<ApplyFlags>();
  CLI::App* command =
      app.add_subcommand("apply", "Bring a map up to date with a delta, or take it back");
  command->footer(
      "The map is the old one or the new one at every moment, also when power is lost; the same\n"
      "command then goes on. The old map stays beside it as MAP.previous.\n\n"
      "Examples:\n"
      "  sightline apply town-1-to-2.sldelta --to town.slmap\n"
      "  sightline apply --rollback --to town.slmap\n"
      "  sightline apply town-1-to-2.sldelta --to town-1.slmap -o town-2.slmap");
  command->add_option("delta", flags->delta, "The delta (.sldelta)");
  command->add_option("--to", flags->map, "The map to bring up to date (.slmap)")->required();
  command->add_option("-o,--out", flags->out, "Write the new map here, leave the old one alone");
  command->add_flag("--rollback", flags->rolls_back, "Take back the last apply");
  command->callback([flags, &status] {
    const Result<void> applied = apply(*flags);
    status = applied ? 0 : report_error(applied.error());
  });
}

}  // namespace sightline
