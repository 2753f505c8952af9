#include <cstdio>
#include <memory>

#include "compiler/driver/commands.h"
#include "compiler/driver/console.h"
#include "formats/map/describe.h"
#include "formats/map/describe_site.h"
#include "formats/map/map_reader.h"

namespace sightline {
namespace {

struct InspectFlags {
  std::string map;
  int site = -1;  // below 0: the map as a whole
};

Result<void> inspect(const InspectFlags& flags) {
  const Result<CompiledMap> map = read_map(flags.map);
  if (!map) return map.error();
  if (flags.site >= 0) {
    const Result<std::string> text = describe_site(*map, static_cast<std::size_t>(flags.site));
    if (!text) return text.error();
    std::fputs(text->c_str(), stdout);
    return {};
  }
  const Result<MapSummary> summary = verify_map(flags.map);
  if (!summary) return summary.error();
  std::fputs(describe(*map).c_str(), stdout);
  std::fputs(describe(*summary).c_str(), stdout);
  return {};
}

}  // namespace

void add_inspect_command(CLI::App& app, int& status) {
  const auto flags = std::make_shared<InspectFlags>();
  CLI::App* command = app.add_subcommand(
      "inspect", "Say in words what a map holds: sites, ranges, promises, model card");
  command->footer(
      "Examples:\n"
      "  sightline inspect town.slmap\n"
      "  sightline inspect town.slmap --site 40    # why is the range long here?");
  command->add_option("map", flags->map, "The map (.slmap)")->required();
  command->add_option("--site", flags->site, "Explain the choice at this site instead")
      ->check(CLI::Range(0, INT32_MAX));
  command->callback([flags, &status] {
    const Result<void> inspected = inspect(*flags);
    status = inspected ? 0 : report_error(inspected.error());
  });
}

}  // namespace sightline
